"""What goes out to participants: questions, sentinels, pages, batches."""
