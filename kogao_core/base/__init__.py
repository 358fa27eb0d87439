"""What every room may use: words, files, numbers, threads. It uses nothing of Kogao."""
