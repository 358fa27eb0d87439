"""JPEG files block by block: unchanged blocks are copied."""
