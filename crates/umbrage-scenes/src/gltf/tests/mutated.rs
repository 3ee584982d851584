//! Files with changed JSON and cut accessors never panic, and what loads lists what it ignores.

use super::{
    model::{TestModel, first_inputs},
    poses::{morphed, skinned},
    read_plain,
};
use crate::{FilesInMemory, builtin::noise::hash};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use umbrage_core::{Scene, glam::IVec3};

/// Number of mutated files.
const COUNT: i32 = 500;

/// Models that together have all features that are applied, and some that are not.
fn models() -> Vec<TestModel> {
    let mut moved = morphed();
    moved.node(json!({ "mesh": 0, "weights": [0.25] }));
    let mut posed = skinned();
    posed.node(json!({ "mesh": 0, "skin": 0 }));
    let mut copied = TestModel::square();
    let translations = copied.floats("VEC3", 3, &[0.0, 0.0, 0.0, 0.0, 0.0, 5.0]);
    copied.json["extensionsUsed"] = json!([
        "EXT_mesh_gpu_instancing",
        "KHR_node_visibility",
        "KHR_materials_sheen"
    ]);
    copied.json["nodes"][0]["extensions"] = json!({
        "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": translations } },
        "KHR_node_visibility": { "visible": true },
    });
    let colors = copied.floats("VEC3", 3, &[0.5; 12]);
    copied.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
    copied.add(
        "animations",
        json!({
            "samplers": [{ "input": 0, "output": 0 }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "scale" } }],
        }),
    );
    let mut all = first_inputs();
    all.extend([moved, posed, copied]);
    all
}

/// Returns the pointers of all members and elements.
fn pointers(value: &Value, at: &str, out: &mut Vec<String>) {
    let mut visit = |key: &str, child: &Value| {
        let pointer = format!("{at}/{key}");
        pointers(child, &pointer, out);
        out.push(pointer);
    };
    match value {
        Value::Object(members) => members.iter().for_each(|(key, child)| visit(key, child)),
        Value::Array(list) => {
            let elements = list.iter().enumerate();
            elements.for_each(|(i, child)| visit(&i.to_string(), child));
        }
        _ => {}
    }
}

/// Changes a model: a field is changed, removed or duplicated, or an accessor is cut.
fn mutate(model: &mut TestModel, seed: i32) {
    let pick = |what: i32, of: usize| hash(IVec3::new(seed, what, 41)) as usize % of;
    let mut all = Vec::new();
    pointers(&model.json, "", &mut all);
    let pointer = &all[pick(0, all.len())];
    let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
    match pick(1, 4) {
        0 => {
            let odd = [
                json!(null),
                json!(-1),
                json!(0),
                json!(1),
                json!(3),
                json!(1e39),
                json!(4_294_967_296_u64),
                json!("x"),
                json!([]),
                json!({}),
                json!(false),
            ];
            let value = odd[pick(2, odd.len())].clone();
            *model.json.pointer_mut(pointer).expect("there") = value;
        }
        1 => match model.json.pointer_mut(parent).expect("there") {
            Value::Object(members) => drop(members.remove(key)),
            Value::Array(list) => drop(list.remove(key.parse().expect("an index"))),
            _ => unreachable!("a parent"),
        },
        2 => match model.json.pointer_mut(parent).expect("there") {
            Value::Object(members) => {
                let copy = members[key].clone();
                members.insert(format!("{key}_0"), copy);
            }
            Value::Array(list) => {
                let copy = list[key.parse::<usize>().expect("an index")].clone();
                list.push(copy);
            }
            _ => unreachable!("a parent"),
        },
        _ => {
            let accessors = model.json["accessors"].as_array_mut();
            if let Some(accessors) = accessors.filter(|list| !list.is_empty()) {
                let place = pick(2, accessors.len());
                let count = accessors[place]["count"].as_u64().unwrap_or(0);
                accessors[place]["count"] = json!(count / 2 + pick(3, 3) as u64);
            }
        }
    }
}

/// Reports whether a document uses a feature that is ignored, and whether a notice lists it.
fn uses_and_notices(json: &Value, scene: &Scene) -> Vec<(&'static str, bool, bool)> {
    let has_notice = |part: &str| scene.notices.iter().any(|notice| notice.contains(part));
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let primitives: Vec<Value> = list(&json["meshes"])
        .iter()
        .flat_map(|mesh| list(&mesh["primitives"]))
        .collect();
    let has_colors = primitives.iter().any(|primitive| {
        let attributes = primitive["attributes"].as_object();
        let is_color = |key: &String| {
            let set = key.strip_prefix("COLOR_");
            set.is_some_and(|set| set.parse::<u32>().is_ok())
        };
        attributes.is_some_and(|attributes| attributes.keys().any(is_color))
    });
    let is_flat = |primitive: &Value| primitive["mode"].as_u64().is_some_and(|mode| mode < 4);
    let has_texture = |key: &str| {
        list(&json["materials"])
            .iter()
            .any(|material| material[key].is_object())
    };
    let applied: BTreeSet<&str> = [
        "EXT_mesh_gpu_instancing",
        "KHR_lights_punctual",
        "KHR_mesh_quantization",
        "KHR_node_visibility",
        "KHR_texture_transform",
    ]
    .into();
    let has_other_extension = list(&json["extensionsUsed"])
        .iter()
        .any(|name| !applied.contains(name.as_str().unwrap_or("")));
    vec![
        (
            "animations",
            !list(&json["animations"]).is_empty(),
            has_notice("animations are"),
        ),
        ("colours", has_colors, has_notice("COLOR_n")),
        (
            "lines",
            primitives.iter().any(is_flat),
            has_notice("points and lines"),
        ),
        (
            "occlusion",
            has_texture("occlusionTexture"),
            has_notice("occlusion"),
        ),
        (
            "extensions",
            has_other_extension,
            has_notice("extensions are"),
        ),
    ]
}

#[test]
fn mutated_files_never_panic_and_list_what_is_ignored() {
    let models = models();
    let mut loaded = 0;
    let mut noticed = BTreeSet::new();
    for seed in 0..COUNT {
        let mut model = models[seed as usize % models.len()].clone();
        mutate(&mut model, seed);
        let files: FilesInMemory = [("m.glb", model.glb())].into_iter().collect();
        let Ok(scene) = read_plain("m.glb", &files) else {
            continue;
        };
        loaded += 1;
        for (feature, is_used, is_noticed) in uses_and_notices(&model.json, &scene) {
            assert_eq!(is_used, is_noticed, "{feature} of {seed}: {}", model.json);
            if is_noticed {
                noticed.insert(feature);
            }
        }
    }
    assert!(3 * loaded >= COUNT, "{loaded} of {COUNT} files load");
    assert!(
        noticed.contains("animations") && noticed.contains("colours"),
        "{noticed:?}"
    );
}
