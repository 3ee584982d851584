//! What all pages have in common: one file that opens alone, with its style, its data and its scripts inside.

use serde::Serialize;

/// A page's own parts.
pub(crate) struct Page<'a> {
    pub(crate) title: &'a str,
    pub(crate) style: &'a str,
    /// The elements that scripts fill.
    pub(crate) body: &'a str,
    /// In the order in which they run; they read the data from the element `data`.
    pub(crate) scripts: &'a [&'a str],
}

impl Page<'_> {
    /// The whole page around its data.
    ///
    /// # Errors
    /// When the data can't be written as JSON.
    pub(crate) fn html(&self, data: &impl Serialize) -> serde_json::Result<String> {
        let Self {
            title,
            style,
            body,
            scripts,
        } = self;
        let data = for_script(&serde_json::to_string(data)?);
        let scripts: String = scripts
            .iter()
            .map(|script| format!("<script>{script}</script>\n"))
            .collect();
        Ok(format!(
            r#"<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{title}</title>
<style>{style}</style>
</head>
<body>
{body}<script type="application/json" id="data">{data}</script>
{scripts}</body>
</html>
"#
        ))
    }
}

/// JSON that no script element ends within: `<` is written as an escape.
fn for_script(json: &str) -> String {
    json.replace('<', "\\u003c")
        .replace('\u{2028}', "\\u2028")
        .replace('\u{2029}', "\\u2029")
}

#[cfg(test)]
mod tests {
    use super::*;

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
            (3, 0)
        );
        let (_, rest) = html.split_once("id=\"data\">").expect("there");
        let (json, rest) = rest.split_once("</script>").expect("there");
        assert_eq!(serde_json::from_str::<String>(json).expect("valid"), data);
        assert_eq!(
            rest,
            "\n<script>one()</script>\n<script>two()</script>\n</body>\n</html>\n"
        );
    }
}
