"""Parts of the editor, each with its own signals joined; `editor.Editor` puts them together."""
