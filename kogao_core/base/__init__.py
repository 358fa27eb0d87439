"""What every room may use: words and languages, files that appear whole, geometry, threads.

It uses nothing of Kogao.
"""
