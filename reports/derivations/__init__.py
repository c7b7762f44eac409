"""The derivation report, whole and in brief, put together from sections."""
