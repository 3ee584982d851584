//! Self-contained pages: one file with its style, data, scripts and images.

use base64::{Engine, engine::general_purpose::STANDARD};
use serde::Serialize;

/// Style of all pages: light and dark colours, and the body.
pub(crate) const STYLE: &str = include_str!("page.css");
/// Script of all pages: elements, tables, controls.
pub(crate) const SCRIPT: &str = include_str!("elements.js");

/// A page that scripts fill.
pub(crate) struct Page<'a> {
    pub(crate) title: &'a str,
    /// Style in addition to [`STYLE`].
    pub(crate) style: &'a str,
    /// Elements that scripts fill.
    pub(crate) body: &'a str,
    /// Scripts in the order of execution, after [`SCRIPT`], which reads the data from the element
    /// `data`.
    pub(crate) scripts: &'a [&'a str],
}

impl Page<'_> {
    /// Returns the whole page with its data.
    ///
    /// # Errors
    /// Errors if the data can't be serialised as JSON.
    pub(crate) fn html(&self, data: &impl Serialize) -> serde_json::Result<String> {
        let data = for_script(&serde_json::to_string(data)?);
        let all = std::iter::once(&SCRIPT).chain(self.scripts);
        let scripts: String = all
            .map(|script| format!("<script>{script}</script>\n"))
            .collect();
        let body = format!(
            "{}<script type=\"application/json\" id=\"data\">{data}</script>\n{scripts}",
            self.body
        );
        let style = format!("{STYLE}{}", self.style);
        Ok(document(self.title, &style, &body))
    }
}

/// Returns a page with a title (plain text), a style sheet and a body (markup that ends with a line
/// break).
pub(crate) fn document(title: &str, style: &str, body: &str) -> String {
    let title = escape(title);
    format!(
        r#"<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>{style}</style>
</head>
<body>
{body}</body>
</html>
"#
    )
}

/// Escapes plain text for elements and quoted attributes of HTML and SVG.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&#34;")
}

/// Returns a file as a data URI. `media_type` is for example `image/png`.
pub(crate) fn data_uri(media_type: &str, bytes: &[u8]) -> String {
    format!("data:{media_type};base64,{}", STANDARD.encode(bytes))
}

/// Escapes `<` and line separators in JSON, so that it can't end a script element.
fn for_script(json: &str) -> String {
    json.replace('<', "\\u003c")
        .replace('\u{2028}', "\\u2028")
        .replace('\u{2029}', "\\u2029")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_no_markup() {
        assert_eq!(
            escape("<b title=\"a & b\">"),
            "&lt;b title=&#34;a &amp; b&#34;&gt;"
        );
    }

    #[test]
    fn data_cannot_end_its_element_and_comes_back() {
        let page = Page {
            title: "t",
            style: "s { }",
            body: "<main></main>\n",
            scripts: &["one()", "two()"],
        };
        let data = "</script><img> {style} \u{2028}";
        let html = page.html(&data).expect("a string");
        assert_eq!(
            (
                html.matches("</script>").count(),
                html.matches("<img>").count()
            ),
            (4, 0)
        );
        let (_, rest) = html.split_once("id=\"data\">").expect("there");
        let (json, rest) = rest.split_once("</script>").expect("there");
        assert_eq!(serde_json::from_str::<String>(json).expect("valid"), data);
        let own = "</script>\n<script>one()</script>\n<script>two()</script>\n</body>\n</html>\n";
        assert!(
            rest.starts_with("\n<script>") && rest.ends_with(own),
            "{rest}"
        );
    }
}
