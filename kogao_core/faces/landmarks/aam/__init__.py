"""The paper's own extractor of feature points: an Active Appearance Model (section 3.1)."""
