"""Read lessons that are written as one TOML and one Markdown file in a folder."""
