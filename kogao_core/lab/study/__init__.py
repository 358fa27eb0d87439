"""Rating studies (table 1, figures 10 and 11): pictures, ratings and reports."""
