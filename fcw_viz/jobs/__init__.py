"""What commands and pages have done for them, with a progress bar."""
