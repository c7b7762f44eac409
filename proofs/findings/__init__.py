"""What is said of a subject: verdicts, facts with their words, and exact numbers in JSON."""
