//! Names of a WGSL text under a prefix, so that several texts fit into one shader.

use crate::tokens::{Token, tokens};
use std::collections::BTreeSet;
use umbrage_core::Invalid;

/// Returns the text with `prefix` before every name that it declares at module level, wherever that name stands.
///
/// Names of locals and of struct fields change along where they are spelled like one of those, in all places alike, so the
/// text means the same.
///
/// # Errors
/// Errors if the prefix can't begin a WGSL identifier.
pub(crate) fn with_prefix(text: &str, prefix: &str) -> Result<String, Invalid> {
    check(prefix)?;
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

/// Errors if the prefix can't begin an identifier: see "Identifiers" in the WGSL specification. A single `_` would be a
/// placeholder with some names, and two are reserved.
fn check(prefix: &str) -> Result<(), Invalid> {
    let first_is_letter = prefix
        .chars()
        .next()
        .is_none_or(|c| c.is_ascii_alphabetic());
    let rest_is_word = prefix
        .chars()
        .all(|c| c.is_ascii_alphanumeric() || c == '_');
    if first_is_letter && rest_is_word {
        return Ok(());
    }
    Err(Invalid::new(
        "prefix of WGSL names",
        format!("is `{prefix}`"),
        "use a letter, then letters, digits and `_`, such as `sun_`; or nothing",
    ))
}

/// Returns the names of all functions, structs, variables, constants and aliases of a module.
fn global_names<'a>(tokens: &[Token<'a>]) -> BTreeSet<&'a str> {
    let mut names = BTreeSet::new();
    let mut depth = 0_u32;
    let mut declares = false;
    // `var<storage> name`: what stands between angle brackets is no name.
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
    use super::with_prefix;

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
}
