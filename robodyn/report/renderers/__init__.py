"""From reports and findings to HTML, Markdown, SARIF, JUnit, GitHub's commands and LaTeX."""
