"""The methods that drawings are compared with, one file each."""
