"""What users are told: errors of scenes, suggestions, what was removed, progress, results in notebooks."""
