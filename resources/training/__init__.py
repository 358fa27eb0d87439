"""How the files in `resources` that are our own are made: one command each, from a checkout.

None of this is in the wheel; nothing in the program imports it.
"""
