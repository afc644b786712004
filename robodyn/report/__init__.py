"""Results as text, JSON, HTML, Markdown, SARIF, JUnit, GitHub annotations, LaTeX; what pages draw."""
