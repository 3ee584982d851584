//! The second of four tests of twins: the layout of a uniform's fields in Rust and in the shader.

use naga::TypeInner;
use umbrage_core::UniformLayout;

/// Returns the layout that naga computes for the WGSL struct called `name`. Only the struct
/// declarations of `wgsl` are parsed, so the text may call functions and read variables that a
/// backend declares.
///
/// # Errors
/// Returns an error if the structs don't compile, or none has that name.
pub fn wgsl_layout(wgsl: &str, name: &str) -> Result<UniformLayout, String> {
    let structs: String = wgsl
        .match_indices("struct ")
        .filter_map(|(at, _)| declaration(&wgsl[at..]))
        .collect();
    let module = naga::front::wgsl::parse_str(&structs).map_err(|e| e.emit_to_string(&structs))?;
    let found = module
        .types
        .iter()
        .find(|(_, t)| t.name.as_deref() == Some(name));
    match found.map(|(_, t)| &t.inner) {
        Some(TypeInner::Struct { members, span }) => {
            let field =
                |m: &naga::StructMember| (m.name.clone().unwrap_or_default(), u64::from(m.offset));
            Ok(layout(
                name,
                members.iter().map(field).collect(),
                u64::from(*span),
            ))
        }
        _ => Err(format!("no struct `{name}` in\n{structs}")),
    }
}

fn declaration(text: &str) -> Option<&str> {
    Some(&text[..=text.find('}')?])
}

fn layout(name: &str, fields: Vec<(String, u64)>, size: u64) -> UniformLayout {
    // Leak the few names, since layouts have static ones.
    let keep = |s: String| -> &'static str { s.leak() };
    UniformLayout {
        name: keep(name.to_owned()),
        fields: fields.into_iter().map(|(n, o)| (keep(n), o)).collect(),
        size,
    }
}

/// Checks that the shader's layout of the struct equals that of Rust.
///
/// # Errors
/// Returns a message with both layouts.
pub fn check(rust: &UniformLayout, wgsl: &str) -> Result<(), String> {
    let wgsl = wgsl_layout(wgsl, rust.name)?;
    if *rust == wgsl {
        return Ok(());
    }
    Err(format!(
        "`{}` in Rust: {} bytes, {:?}; in WGSL: {} bytes, {:?}",
        rust.name, rust.size, rust.fields, wgsl.size, wgsl.fields
    ))
}
