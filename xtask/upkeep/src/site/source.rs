//! Pages that show the text of code files that other pages link to.

use std::fmt::Write as _;

/// Returns a page with a file's text and line numbers.
pub(super) fn page(path: &str, text: &str) -> String {
    let title = escape_text(path);
    let up = "../".repeat(path.matches('/').count() + 1);
    let mut lines = String::new();
    for (i, line) in text.lines().enumerate() {
        let number = i + 1;
        let line = escape_text(line);
        // Writing into a `String` does not fail.
        let _ = writeln!(
            lines,
            "<span id=\"{number}\" class=\"line\">{number:>5}</span>  {line}"
        );
    }
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<link rel=\"icon\" href=\"data:,\">\n<title>{title}</title>\n\
         <style>{STYLE}</style>\n</head>\n<body>\n<p><a href=\"{up}index.html\">umbrage</a> / {title}</p>\n\
         <pre>{lines}</pre>\n</body>\n</html>\n"
    )
}

const STYLE: &str = "body { margin: 1rem; font: 15px/1.5 system-ui, sans-serif; } pre { overflow-x: auto; font-size: 13px; } \
                     .line { color: #767676; user-select: none; } :root { color-scheme: light dark; }";

/// Returns a text escaped for HTML.
fn escape_text(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::page;

    #[test]
    fn code_is_shown_as_it_is() {
        let html = page("a/b.rs", "if x < 1 && y {\n    \"z\"\n}\n");
        assert!(
            html.contains("    1</span>  if x &lt; 1 &amp;&amp; y {\n"),
            "{html}"
        );
        assert!(html.contains("    2</span>      &quot;z&quot;\n"), "{html}");
        assert!(html.contains("href=\"../../index.html\""), "{html}");
    }
}
