//! Measures the lengths of WGSL functions.

use super::{Length, files::SourceFile};

/// Returns the number of lines of every function. Our WGSL starts functions with `fn ` in the first
/// column, after attributes at most, and ends them with a brace there.
pub(super) fn lengths(source: &SourceFile) -> Vec<Length> {
    let mut out = Vec::new();
    let mut open: Option<(usize, &str)> = None;
    for (i, line) in source.text.lines().enumerate() {
        if let Some((_, name)) = line
            .split_once("fn ")
            .filter(|(before, _)| before.is_empty() || before.starts_with('@'))
        {
            open = Some((i, name.split('(').next().unwrap_or(name)));
        }
        if line.starts_with('}')
            && let Some((first, name)) = open.take()
        {
            out.push(Length {
                size: i - first + 1,
                place: format!("{}:{} {name}", source.path, first + 1),
            });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::{SourceFile, lengths};

    #[test]
    fn functions_are_found_and_structs_are_not() {
        let text = "struct S {\n    x: f32,\n}\n\nfn f(x: f32) -> f32 {\n    return x;\n}\n@compute @workgroup_size(1) fn g() {\n}\n";
        let source = SourceFile {
            path: "x.wgsl".to_owned(),
            text: text.to_owned(),
        };
        let found: Vec<_> = lengths(&source)
            .into_iter()
            .map(|l| format!("{} {}", l.size, l.place))
            .collect();
        assert_eq!(found, ["3 x.wgsl:5 f", "2 x.wgsl:8 g"]);
    }
}
