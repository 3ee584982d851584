//! The second of four nets: where Rust writes a uniform's fields, and where the shader reads them.

use naga::TypeInner;
use umbrage_core::UniformLayout;

/// The layout that naga gives the WGSL struct called `name`. Only the struct declarations of `wgsl`
/// are looked at, so the text may call functions and read variables that a player declares.
///
/// # Errors
/// Errors if the structs don't compile, or none has that name.
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
    // Layouts name things for as long as the program lives; so few may be built here, too.
    let keep = |s: String| -> &'static str { s.leak() };
    UniformLayout {
        name: keep(name.to_owned()),
        fields: fields.into_iter().map(|(n, o)| (keep(n), o)).collect(),
        size,
    }
}

/// Objects unless the shader lays the struct out as Rust does.
///
/// # Errors
/// Both layouts, in words.
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
