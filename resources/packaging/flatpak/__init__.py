"""The program as a Flatpak: its manifest, and all that is fetched for it."""
