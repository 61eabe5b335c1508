"""What a report is made of: judgement, rows, charts."""
