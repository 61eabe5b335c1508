"""The commands of ``suspid``, by what they start from."""
