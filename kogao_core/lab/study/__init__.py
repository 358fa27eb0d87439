"""Table 1 and figures 10 and 11 as a study: pictures to judge, ratings, and what they say."""
