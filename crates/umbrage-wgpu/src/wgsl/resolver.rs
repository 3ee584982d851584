//! The resolver of WGSL texts. No other code modifies a text.
//!
//! * [`assemble`] concatenates files and their imports.
//! * [`constant`] declares a condition: files that read the constant have a variant for each of its
//!   values.
//! * [`with_prefix`] prepends a prefix to every name that a text declares.
//! * [`InputPlaces`] redirects a kernel's uniforms and tables to those of a light of a set.

use std::{collections::BTreeSet, fmt::Display};
use umbrage_core::{Invalid, Module, join};

/// Returns the text of some files and of all files that they import, each once. The imports of a
/// file are listed in a line `// import NAME, NAME`.
pub(crate) fn assemble(files: &[Module], entries: &[&str]) -> String {
    let mut found = Vec::new();
    for name in entries {
        import(files, name, &mut found);
    }
    join(&found)
}

/// Appends a file after those that it imports.
fn import(files: &[Module], name: &str, found: &mut Vec<Module>) {
    let Some(file) = files.iter().find(|file| file.name == name) else {
        return;
    };
    if found.contains(file) {
        return;
    }
    let imports = file
        .text
        .lines()
        .filter_map(|line| line.strip_prefix("// import "));
    for name in imports.flat_map(|names| names.split(", ")) {
        import(files, name, found);
    }
    found.push(*file);
}

/// A piece of WGSL: an identifier or keyword, or the text between two of them.
#[derive(Clone, Copy, Debug)]
struct Token<'a> {
    text: &'a str,
    is_identifier: bool,
}

/// Splits a text into identifiers and single other characters. Numbers and comments are not
/// identifiers.
fn tokens(text: &str) -> Vec<Token<'_>> {
    let mut out = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let is_identifier = first.is_ascii_alphabetic() || first == '_';
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if is_identifier || first.is_ascii_digit() {
            // `1.0f` is a number with a suffix: its letters are part of it.
            rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_')
                .unwrap_or(rest.len())
        } else {
            first.len_utf8()
        };
        let (text, after) = rest.split_at(length);
        out.push(Token {
            text,
            is_identifier,
        });
        rest = after;
    }
    out
}

/// Returns the text with `prefix` prepended to all occurrences of every name that it declares at
/// module level.
///
/// Locals and struct fields with the same spelling are also renamed, consistently, so the text
/// keeps its meaning.
///
/// # Errors
/// Errors if the prefix can't begin a WGSL identifier.
pub(crate) fn with_prefix(text: &str, prefix: &str) -> Result<String, Invalid> {
    check_prefix(prefix)?;
    if prefix.is_empty() {
        return Ok(text.to_owned());
    }
    let tokens = tokens(text);
    let names = global_names(&tokens);
    let mut out = String::with_capacity(text.len() * 2);
    for token in &tokens {
        if token.is_identifier && names.contains(token.text) {
            out.push_str(prefix);
        }
        out.push_str(token.text);
    }
    Ok(out)
}

/// Errors if the prefix can't begin an identifier, see "Identifiers" in the WGSL specification. A
/// single `_` would be a placeholder with some names, and two are reserved.
pub(crate) fn check_prefix(prefix: &str) -> Result<(), Invalid> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let begins_with_letter = !prefix.starts_with(|c: char| !c.is_ascii_alphabetic());
    if begins_with_letter && prefix.chars().all(is_word) {
        return Ok(());
    }
    Err(Invalid::new(
        "prefix of WGSL names",
        format!("is `{prefix}`"),
        "use a letter, then letters, digits and `_`, such as `sun_`; or nothing",
    ))
}

/// Returns the declaration of a constant. Files that read it have a variant for each value;
/// compilers remove the others.
pub(crate) fn constant(name: &str, value: impl Display) -> String {
    format!("const {name} = {value};\n")
}

/// Expressions that replace a kernel's bindings.
#[derive(Debug)]
pub(crate) struct InputPlaces<'a> {
    /// Replaces `kernel`.
    pub(crate) uniforms: &'a str,
    /// The buffer that replaces each `table_n`.
    pub(crate) tables: &'a str,
    /// The first row and the number of rows of each table in the buffer.
    pub(crate) rows: &'a [[String; 2]],
}

impl InputPlaces<'_> {
    /// Returns a kernel's text with its uniforms and tables replaced.
    pub(crate) fn resolve(&self, text: &str) -> String {
        let mut text = text.to_owned();
        for (table, [_, count]) in self.rows.iter().enumerate() {
            text = text.replace(&format!("arrayLength(&table_{table})"), count);
        }
        let mut out = String::with_capacity(text.len() + text.len() / 8);
        // Closing text of each open bracket.
        let mut closing = Vec::new();
        let mut before = "";
        for token in tokens(&text) {
            let table = before.strip_prefix("table_");
            let table = table.and_then(|index| self.rows.get(index.parse::<usize>().ok()?));
            match (token.text, table) {
                ("kernel", _) if before != "." => out += self.uniforms,
                ("[", Some([first, _])) => {
                    out.truncate(out.len() - before.len());
                    out += &format!("{}[{first} + u32(", self.tables);
                    closing.push(")]");
                }
                ("[", None) => {
                    out += "[";
                    closing.push("]");
                }
                ("]", _) => out += closing.pop().unwrap_or("]"),
                (other, _) => out += other,
            }
            before = token.text;
        }
        out
    }
}

/// Returns the names of all functions, structs, variables, constants and aliases of a module.
fn global_names<'a>(tokens: &[Token<'a>]) -> BTreeSet<&'a str> {
    let mut names = BTreeSet::new();
    let mut depth = 0_u32;
    let mut declares = false;
    // Skip the text between angle brackets in `var<storage> name`.
    let mut in_template = false;
    for token in tokens {
        match token.text {
            "{" => depth += 1,
            "}" => depth = depth.saturating_sub(1),
            "<" => in_template = declares,
            ">" => in_template = false,
            "fn" | "struct" | "var" | "const" | "alias" | "override" if depth == 0 => {
                declares = true;
            }
            name if token.is_identifier && declares && !in_template => {
                names.insert(name);
                declares = false;
            }
            _ => {}
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::{InputPlaces, with_prefix};

    const TEXT: &str = "\
// fn comment() {}
struct Map { side: u32, tap: f32 }
@group(1) @binding(0) var<uniform> kernel: Map;
const LAST: f32 = 1.0f;
fn tap(map: Map, x: f32) -> f32 {
    let side = map.side;
    return map.tap * x + f32(side) * LAST;
}
fn receive() -> f32 { return tap(kernel, 2.0); }
";

    #[test]
    fn declared_names_change_everywhere_and_others_nowhere() {
        let expected = "\
// fn comment() {}
struct sun_Map { side: u32, sun_tap: f32 }
@group(1) @binding(0) var<uniform> sun_kernel: sun_Map;
const sun_LAST: f32 = 1.0f;
fn sun_tap(map: sun_Map, x: f32) -> f32 {
    let side = map.side;
    return map.sun_tap * x + f32(side) * sun_LAST;
}
fn sun_receive() -> f32 { return sun_tap(sun_kernel, 2.0); }
";
        assert_eq!(with_prefix(TEXT, "sun_"), Ok(expected.to_owned()));
        assert_eq!(with_prefix(TEXT, ""), Ok(TEXT.to_owned()));
    }

    #[test]
    fn what_begins_no_identifier_is_refused() {
        for wrong in ["1", "_", "__sun", "sun-", "ü", "a b"] {
            let error = with_prefix(TEXT, wrong).expect_err(wrong).to_string();
            assert!(error.contains(wrong), "{error}");
        }
    }

    #[test]
    fn uniforms_and_tables_are_read_from_elsewhere() {
        let text = "\
// the kernel of table_0[1]
fn receive(kernel_size: u32) -> f32 {
    let row = table_0[i / 4u];
    let nested = table_1[table_0[kernel.first].x + 1u];
    if i >= arrayLength(&table_0) { return kernel.lookup.kernel; }
    let last = table_1[arrayLength(&table_1) - 1u];
    return f32(arrayLength(&others)) + weights[1];
}
";
        let expected = "\
// the kernel of table_0[1]
fn receive(kernel_size: u32) -> f32 {
    let row = all[first_0 + u32(i / 4u)];
    let nested = all[first_1 + u32(all[first_0 + u32(numbers[7].first)].x + 1u)];
    if i >= count_0 { return numbers[7].lookup.kernel; }
    let last = all[first_1 + u32(count_1 - 1u)];
    return f32(arrayLength(&others)) + weights[1];
}
";
        let rows = [0, 1].map(|i| [format!("first_{i}"), format!("count_{i}")]);
        let places = InputPlaces {
            uniforms: "numbers[7]",
            tables: "all",
            rows: &rows,
        };
        assert_eq!(places.resolve(text), expected);
    }
}
