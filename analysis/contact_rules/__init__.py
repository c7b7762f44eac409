"""Contact rules: how contacts become motion, one class each."""
