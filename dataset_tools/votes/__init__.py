"""What comes back: results, votes, who is reliable, what people agree on."""
