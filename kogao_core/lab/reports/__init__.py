"""What experiments found as text, tables, files and pages with charts."""
