//! The compute shader around the WGSL half of a twin, generated from its declaration.

use super::Fault;
use naga::{Module as Naga, ScalarKind, TypeInner};
use umbrage_core::{MATH, Module, Twin, join};

/// Returns the number of 32-bit words of a WGSL type, from the digits in its name.
pub(super) fn count(wgsl: &str) -> usize {
    let digits: Vec<usize> = wgsl
        .chars()
        .filter_map(|c| c.to_digit(10))
        .map(|d| d as usize)
        .collect();
    match (
        wgsl.split_once(|c: char| c.is_ascii_digit())
            .map(|(stem, _)| stem),
        &digits[..],
    ) {
        (Some("vec"), [n]) => *n,
        (Some("mat"), [columns, rows]) => columns * rows,
        _ => 1,
    }
}

/// Returns the WGSL scalar type of a type's components.
pub(super) fn scalar(wgsl: &str) -> &'static str {
    match wgsl.trim_end_matches("32").chars().last() {
        Some('u') => "u32",
        Some('i') => "i32",
        _ => "f32",
    }
}

/// Returns the whole shader: the half's dependencies, the half, and the wrapper.
///
/// # Errors
/// Returns an error if the half doesn't compile by itself, is missing, or has another signature
/// than the Rust half.
pub fn shader(twin: &Twin) -> Result<String, Fault> {
    let modules = join(&modules(twin));
    let naga = naga::front::wgsl::parse_str(&modules).map_err(|e| Fault::Wgsl {
        twin: twin.name,
        message: e.emit_to_string(&modules),
    })?;
    check_signature(twin, &naga)?;
    let has_opaque_zero = modules.contains("var<private> opaque_zero");
    Ok(modules + &wrapper(twin, has_opaque_zero))
}

/// Returns `math`, the dependencies and the half's own module, each once. The twin's own text takes
/// precedence.
fn modules(twin: &Twin) -> Vec<Module> {
    let mut out: Vec<Module> = Vec::new();
    for module in [&[MATH], twin.needs].concat() {
        if module.name != twin.module.name && !out.contains(&module) {
            out.push(module);
        }
    }
    out.push(twin.module);
    out
}

/// Returns the types of a function's parameters and result in WGSL's short spelling. `None` if it
/// is missing.
pub fn wgsl_types(naga: &Naga, function: &str) -> Option<(Vec<String>, String)> {
    let (_, f) = naga
        .functions
        .iter()
        .find(|(_, f)| f.name.as_deref() == Some(function))?;
    let spell = |ty| spell(&naga.types[ty]);
    let result = f
        .result
        .as_ref()
        .map_or("nothing".to_owned(), |r| spell(r.ty));
    Some((f.arguments.iter().map(|a| spell(a.ty)).collect(), result))
}

fn spell(ty: &naga::Type) -> String {
    let letter = |kind| match kind {
        ScalarKind::Float => 'f',
        ScalarKind::Sint => 'i',
        ScalarKind::Uint => 'u',
        _ => '?',
    };
    match ty.inner {
        TypeInner::Scalar(s) => format!("{}{}", letter(s.kind), 8 * s.width),
        TypeInner::Vector { size, scalar } => format!("vec{}{}", size as u8, letter(scalar.kind)),
        TypeInner::Matrix {
            columns,
            rows,
            scalar,
        } => {
            format!("mat{}x{}{}", columns as u8, rows as u8, letter(scalar.kind))
        }
        _ => ty
            .name
            .clone()
            .unwrap_or_else(|| "an unnamed type".to_owned()),
    }
}

fn check_signature(twin: &Twin, naga: &Naga) -> Result<(), Fault> {
    let signature =
        |parameters: &[String], result: &str| format!("({}) -> {result}", parameters.join(", "));
    let rust = signature(
        &twin
            .parameters
            .iter()
            .map(|&p| p.to_owned())
            .collect::<Vec<_>>(),
        twin.result,
    );
    let wgsl = wgsl_types(naga, twin.name).map_or("missing".to_owned(), |(p, r)| signature(&p, &r));
    if rust == wgsl {
        return Ok(());
    }
    Err(Fault::Signature {
        twin: twin.name,
        rust,
        wgsl,
    })
}

fn wrapper(twin: &Twin, has_opaque_zero: bool) -> String {
    let mut next = 0;
    let arguments: Vec<String> = twin
        .parameters
        .iter()
        .map(|ty| {
            let first = next;
            next += count(ty);
            let words =
                (first..next).map(|i| format!("bitcast<{}>(twin_in[i + {i}u])", scalar(ty)));
            format!("{ty}({})", words.collect::<Vec<_>>().join(", "))
        })
        .collect();
    let outputs = count(twin.result);
    let stores: String = (0..outputs)
        .map(|k| {
            format!(
                "    twin_out[o + {k}u] = bitcast<u32>(result{});\n",
                component(twin.result, k)
            )
        })
        .collect();
    // Without it, a compiler may fuse operations that the module keeps apart.
    let set_opaque_zero = if has_opaque_zero {
        "    opaque_zero = twin_in[arrayLength(&twin_in) - 1u];\n"
    } else {
        ""
    };
    format!(
        "@group(0) @binding(0) var<storage, read> twin_in: array<u32>;\n\
         @group(0) @binding(1) var<storage, read_write> twin_out: array<u32>;\n\
         @compute @workgroup_size(64) fn twin_main(@builtin(global_invocation_id) id: vec3u) {{\n{set_opaque_zero}    \
             let i = id.x * {next}u;\n    let o = id.x * {outputs}u;\n    \
             let result = {}({});\n{stores}}}\n",
        twin.name,
        arguments.join(", "),
    )
}

/// Returns the expression for a value's `k`th component.
fn component(wgsl: &str, k: usize) -> String {
    match count(wgsl) {
        1 => String::new(),
        _ if wgsl.starts_with("mat") => {
            let rows = count(wgsl) / wgsl[3..4].parse::<usize>().unwrap_or(1);
            format!("[{}][{}]", k / rows, k % rows)
        }
        _ => format!("[{k}]"),
    }
}
