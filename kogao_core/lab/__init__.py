"""The laboratory: experiments on photographs, rival methods, a blind study."""
