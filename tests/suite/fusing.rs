//! Tests that shaders which decide whether a point is lit have no driver-dependent operations,
//! except for those of a list with reasons.

use glam::UVec2;
use umbrage_core::{Cascades, Geometry, Layout, Scene, ShadowTechnique, View};
use umbrage_techniques::{
    Exact, ExactStructure, Planar, ShadowMap, ShadowVolumes, Soft, Traced, Unshadowed,
};
use umbrage_tests::fusible::{Liberty, liberties, unset_guards};
use umbrage_wgpu::receive_wgsl;

/// Functions that may have driver-dependent operations, with reasons.
const ALLOWED: &[(&str, &str)] = &[
    (
        "residual",
        "its products are of 12 bits each, so they and their sums are exact",
    ),
    ("quotient", "corrects the device's quotient"),
    ("root", "corrects the device's root"),
    (
        "safe_inverse",
        "for boxes, which are padded by more than it is off",
    ),
    (
        "children_at",
        "rounds by less than a hierarchy's margins (exact/light_frame.rs)",
    ),
    ("point_of", "rounds by less than a hierarchy's margins"),
    (
        "position_of",
        "vertices of 16 bits, which the vertex stage of a device may decode otherwise, too",
    ),
    ("footprint_of", "bounds with a margin of 1 % of a step"),
    ("part_between", "bounds with a margin of 1 % of a step"),
    ("part_of_corners", "bounds with a margin of 1 % of a step"),
];

/// Returns a built-in scene with an image of 16 by 16 pixels, since only shader texts are needed.
fn small(name: &str) -> (Scene, Geometry) {
    let mut scene = (umbrage_scenes::find(name).expect("a built-in scene").build)();
    scene.cameras[0].size = UVec2::splat(16);
    let geometry = Geometry::bake(&scene).expect("built-in scenes are valid");
    (scene, geometry)
}

fn texts() -> Vec<(String, String)> {
    let techniques: [Box<dyn ShadowTechnique>; 7] = [
        Box::new(Unshadowed::default()),
        Box::new(Traced::default()),
        Box::new(Exact::default()),
        Box::new(Exact {
            structure: ExactStructure::Hierarchy,
        }),
        Box::new(Soft::default()),
        Box::new(ShadowVolumes::default()),
        Box::new(Planar::default()),
    ];
    let mut out = Vec::new();
    for name in ["cubes", "lamp-in-room", "c10-chequered-card"] {
        let (scene, geometry) = small(name);
        let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
        for technique in &techniques {
            if let Ok(recipe) = technique.recipe(&view) {
                let text = receive_wgsl(&recipe, 0, "").expect("no prefix");
                out.push((format!("{} in {name}", technique.name()), text));
            }
        }
    }
    // The others have alpha tests with sampled textures, or normalized normals.
    let deciding = ["cast", "ids", "receivers", "corners"];
    let placing = umbrage_wgpu::placing_shaders().into_iter();
    out.extend(
        placing
            .filter(|(name, _)| deciding.contains(name))
            .map(|(name, text)| (name.to_owned(), text)),
    );
    out
}

#[test]
fn what_decides_leaves_nothing_to_drivers() {
    let texts = texts();
    assert!(texts.len() >= 14, "only {} texts", texts.len());
    let mut faults = Vec::new();
    for (label, text) in texts {
        for (function, liberty) in liberties(&text).expect("valid WGSL") {
            if ALLOWED.iter().all(|(name, _)| *name != function) {
                faults.push(format!("{label}: `{function}` has {liberty}"));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Compilers know the initial value of a private variable, and may fuse products before the first
/// store.
#[test]
fn every_technique_guards_its_products_from_the_start() {
    let mut checked = 0;
    let mut faults = Vec::new();
    for name in ["cubes", "lamp-in-room", "far-range"] {
        let (scene, geometry) = small(name);
        let view = View::new(&scene.cameras[0], &scene.lights[0], &geometry);
        for entry in umbrage_techniques::all() {
            let preset = (entry.preset)();
            let blended = Layout::Cascades(Cascades {
                blend: 4.0,
                ..Cascades::default()
            });
            let with_cascades = preset.map().map(|map| {
                preset.with_map(ShadowMap {
                    layout: blended,
                    ..*map
                })
            });
            for preset in [Some(preset), with_cascades].into_iter().flatten() {
                let Ok(recipe) = preset.technique().recipe(&view) else {
                    continue;
                };
                let text = receive_wgsl(&recipe, 0, "").expect("no prefix");
                let unset = unset_guards(&text, "opaque_zero", &["receive"]).expect("valid WGSL");
                checked += 1;
                faults.extend((!unset.is_empty()).then(|| format!("{} in {name}", entry.name)));
            }
        }
    }
    assert!(checked > 60, "only {checked} texts were checked");
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Entry points that shade, and passes whose bounds have margins (`exact/on_device`), need no
/// guard.
#[test]
fn shaders_that_place_guard_their_products_from_the_start() {
    for (name, text) in umbrage_wgpu::placing_shaders() {
        assert!(text.contains("opaque_zero = "), "{name}");
        let unset = unset_guards(&text, "opaque_zero", &[]).expect("valid WGSL");
        assert!(unset.is_empty(), "{name}: {unset:?}");
    }
}

#[test]
fn products_before_their_guard_is_set_are_found() {
    for (body, is_found) in [
        ("guard = seed; return guarded(a);", false),
        ("let p = guarded(a); guard = seed; return p;", true),
        ("return guarded(a);", true),
        ("return a;", false),
        ("if a > 0.0 { guard = seed; } return guarded(a);", true),
        (
            "if a > 0.0 { guard = seed; } else { guard = seed; } return guarded(a);",
            false,
        ),
        ("loop { guard = seed; break; } return guarded(a);", true),
        ("start(); return guarded(a);", false),
    ] {
        let text = format!(
            "var<private> guard: u32;
            var<private> seed: u32;
            fn start() {{ guard = seed; }}
            fn guarded(a: f32) -> f32 {{ return bitcast<f32>(bitcast<u32>(a * a) ^ guard); }}
            fn f(a: f32) -> f32 {{ {body} }}"
        );
        let found = unset_guards(&text, "guard", &["f"]).expect("valid WGSL");
        assert_eq!(!found.is_empty(), is_found, "{body}");
    }
}

/// The check finds each pattern, and no others.
#[test]
fn each_pattern_is_found() {
    for (body, expected) in [
        ("return a * b + c;", Some(Liberty::FusibleSum)),
        ("return c - a * b;", Some(Liberty::FusibleSum)),
        ("let p = -(a * b); return p + c;", Some(Liberty::FusibleSum)),
        (
            "var p = a * b; p += c; return p;",
            Some(Liberty::FusibleSum),
        ),
        ("return times(a, b) + c;", Some(Liberty::FusibleSum)),
        ("return plus(a * b, c);", Some(Liberty::FusibleSum)),
        ("return (vec2f(a, b) * c).x + a;", Some(Liberty::FusibleSum)),
        (
            "return select(a, a * b, c > 0.0) + c;",
            Some(Liberty::FusibleSum),
        ),
        (
            "return dot(vec2f(a, b), vec2f(b, c));",
            Some(Liberty::FusibleBuiltIn("`dot`".to_owned())),
        ),
        (
            "return mix(a, b, c);",
            Some(Liberty::FusibleBuiltIn("`mix`".to_owned())),
        ),
        (
            "return (mat2x2f(a, b, c, a) * vec2f(a, b)).x;",
            Some(Liberty::FusibleBuiltIn("a product of a matrix".to_owned())),
        ),
        ("return a / b;", Some(Liberty::Quotient)),
        ("return sqrt(a);", Some(Liberty::Root)),
        ("return a * 0.5 + b * 2.0;", None),
        ("return a / 4.0 - c;", None),
        ("return a * b * c;", None),
        ("return max(a * b, 1.0) + c;", None),
        (
            "return bitcast<f32>(bitcast<u32>(a * b) ^ hidden) + c;",
            None,
        ),
    ] {
        let text = format!(
            "var<private> hidden: u32;
            fn times(a: f32, b: f32) -> f32 {{ return a * b; }}
            fn plus(a: f32, b: f32) -> f32 {{ return a + b; }}
            fn f(a: f32, b: f32, c: f32) -> f32 {{ {body} }}"
        );
        let found = liberties(&text).expect("valid WGSL").into_iter().next();
        assert_eq!(found.map(|(_, liberty)| liberty), expected, "{body}");
    }
}
