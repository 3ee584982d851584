//! `[[object]]`.

use super::table::{Item, Table};
use crate::{
    SceneError, obj,
    primitives::{block, grid, icosphere},
};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use umbrage_core::glam::{Affine3A, EulerRot, Mat4, Quat, Vec3, Vec4};
use umbrage_core::{Instance, Mesh, Scene};

const KEYS: &[&str] = &["mesh", "shape", "matrix", "translate", "rotate_degrees", "scale", "casts", "receives"];
const SHAPES: &[&str] = &["plane", "box", "sphere"];
/// Splits of an icosahedron: 5,120 triangles.
const SPHERE_SPLITS: u32 = 4;

/// Adds meshes, each once, and instances.
pub(super) fn read_all(tables: &[Table<'_>], folder: &Path, scene: &mut Scene) -> Result<(), SceneError> {
    let mut known = HashMap::new();
    for table in tables {
        table.only(KEYS)?;
        let (key, item) = shape_or_mesh(table, folder)?;
        let mesh = match known.get(&key) {
            Some(&mesh) => mesh,
            None => {
                scene.meshes.push(make(&key, &item)?);
                known.insert(key, scene.meshes.len() - 1);
                scene.meshes.len() - 1
            }
        };
        let (casts, receives) = (table.flag_or_true("casts")?, table.flag_or_true("receives")?);
        scene.instances.push(Instance { mesh, world_from_local: placement(table)?, casts, receives });
    }
    Ok(())
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Source {
    Shape(String),
    Model(PathBuf),
}

fn shape_or_mesh<'a>(table: &Table<'a>, folder: &Path) -> Result<(Source, Item<'a>), SceneError> {
    match (table.get("shape"), table.get("mesh")) {
        (Some(item), None) => Ok((Source::Shape(item.word(SHAPES)?.to_owned()), item)),
        (None, Some(item)) => {
            let path = folder.join(item.text()?);
            let is_obj = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj"));
            item.require(is_obj, &format!("is `{}`, not a .obj file", path.display()), "name a Wavefront OBJ file")?;
            Ok((Source::Model(path), item))
        }
        (Some(_), Some(item)) => Err(item.fault("stands beside `shape`", "keep one of the two")),
        (None, None) => {
            Err(table.fault("has neither `shape` nor `mesh`", "add shape = \"box\" or mesh = \"model.obj\""))
        }
    }
}

fn make(source: &Source, item: &Item<'_>) -> Result<Mesh, SceneError> {
    match source {
        Source::Shape(name) => Ok(Mesh { name: name.clone(), ..shape(name) }),
        Source::Model(path) => {
            obj::load_mesh(path).map_err(|source| SceneError::Named { place: item.place(), source: Box::new(source) })
        }
    }
}

/// All reach from -1 to 1.
fn shape(name: &str) -> Mesh {
    match name {
        "plane" => grid([1.0, 1.0], [1, 1], |_, _| 0.0),
        "box" => block(Vec3::NEG_ONE, Vec3::ONE),
        _ => icosphere(Vec3::ZERO, 1.0, SPHERE_SPLITS),
    }
}

fn placement(table: &Table<'_>) -> Result<Affine3A, SceneError> {
    let steps = ["translate", "rotate_degrees", "scale"].map(|key| table.get(key));
    let Some(item) = table.get("matrix") else { return from_steps(&steps) };
    if let Some(other) = steps.iter().flatten().next() {
        return Err(other.fault("stands beside `matrix`", "keep either the matrix or the steps"));
    }
    let rows = item.list(4, "four rows of four numbers")?;
    let rows: Vec<Vec4> = rows.iter().map(row).collect::<Result<_, _>>()?;
    let matrix = Mat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose();
    item.require(rows[3] == Vec4::W, &format!("ends in the row {}", rows[3]), "end it in [0, 0, 0, 1]")?;
    not_flat(&item, Affine3A::from_mat4(matrix))
}

fn row(item: &Item<'_>) -> Result<Vec4, SceneError> {
    let numbers: Vec<f32> =
        item.list(4, "rows of four numbers")?.iter().map(|number| number.number()).collect::<Result<_, _>>()?;
    Ok(Vec4::from_slice(&numbers))
}

/// Scaled first, then turned about x, y and z in this order, then moved.
fn from_steps([translate, rotate, scale]: &[Option<Item<'_>>; 3]) -> Result<Affine3A, SceneError> {
    let vec3 = |item: &Option<Item<'_>>| item.as_ref().map_or(Ok(Vec3::ZERO), Item::vec3);
    let angles = vec3(rotate)? * std::f32::consts::PI / 180.0;
    let turn = Quat::from_euler(EulerRot::XYZEx, angles.x, angles.y, angles.z);
    let place =
        |size| -> Result<_, SceneError> { Ok(Affine3A::from_scale_rotation_translation(size, turn, vec3(translate)?)) };
    match scale {
        Some(item) => not_flat(item, place(scale_of(item)?)?),
        None => place(Vec3::ONE),
    }
}

/// One number for all axes, or one for each.
fn scale_of(item: &Item<'_>) -> Result<Vec3, SceneError> {
    if item.value.is_array() { item.vec3() } else { item.number().map(Vec3::splat) }
}

fn not_flat(item: &Item<'_>, place: Affine3A) -> Result<Affine3A, SceneError> {
    let flat = place.matrix3.as_dmat3().determinant() == 0.0;
    item.require(!flat, "flattens the object", "use sizes other than zero")?;
    Ok(place)
}
