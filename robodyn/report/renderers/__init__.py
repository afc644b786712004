"""From reports and findings to text, HTML, Markdown, SARIF, JUnit, GitHub's commands and LaTeX."""
