//! The table `[[object]]`.

use super::{
    look::{self, LookTable},
    table::{Item, Table},
};
use crate::{
    Files, SceneError,
    detail::{TextureFiles, with_tangents},
    far::{self, Box64},
    gltf,
    lone_model::SIZES,
    model_part::ModelPart,
    obj,
    primitives::{block, grid, icosphere, map_mesh},
    scene_of_file::SceneOfFile,
};
use std::collections::{BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};
use umbrage_core::glam::{Affine3A, DAffine3, DMat4, DVec3, DVec4, EulerRot, Quat, Vec3};
use umbrage_core::{AlphaCutout, AlphaFilter, Anchor, Instance, Material, Mesh, Scene, invalid};

const KEYS: [&str; 8] = [
    "mesh",
    "shape",
    "matrix",
    "translate",
    "rotate_degrees",
    "scale",
    "casts",
    "receives",
];
const SHAPES: &[&str] = &["plane", "box", "sphere"];
/// Subdivisions of an icosahedron, for 5,120 triangles.
const SPHERE_SPLITS: u32 = 4;

/// Adds meshes, each once, and their instances. Returns the anchor that positions are relative to:
/// `anchor`, or one for the objects and this eye.
pub(super) fn read_all(
    tables: &[Table<'_>],
    folder: &Path,
    files: &dyn Files,
    anchor: Result<Anchor, Option<DVec3>>,
    scene: &mut Scene,
) -> Result<Anchor, SceneError> {
    let mut placed = Vec::new();
    let mut known = HashMap::new();
    let mut filtered = FilteredMaterials::default();
    let mut textures = TextureFiles::new(files);
    for table in tables {
        table.only(&[KEYS.as_slice(), &look::KEYS].concat())?;
        // Make the parts of the model, or reuse them.
        let (source, item) = shape_or_mesh(table, folder)?;
        let look = look::read(table, folder, &mut textures, scene)?;
        let needs = Needs::of_look(look.as_ref());
        let key = (source, needs);
        if !known.contains_key(&key) {
            let parts = make(&key.0, &needs, &item, &mut textures, scene)?;
            known.insert(key.clone(), parts);
        }
        let parts = &known[&key];
        check_coordinates(look.as_ref(), parts, scene)?;
        // Add the material of the object's look.
        let own = look.map(|look| {
            scene.materials.push(look.material);
            scene.materials.len() - 1
        });
        let filter = look::filter_of_model(table)?;
        if let Some((_, item)) = &filter {
            let has_holes = |part: &ModelPart| alpha_of(part.material, scene).is_some();
            item.require(
                parts.iter().any(has_holes),
                "is set, but the model has no alpha test",
                "leave it out, or add alpha_map = \"leaf.png\"",
            )?;
        }
        // Place the parts.
        let casts = table.flag_or_true("casts")?;
        let mut local = Box64::EMPTY;
        parts
            .iter()
            .for_each(|part| part.add_to(&mut local, &scene.meshes));
        let parts = parts.clone();
        let material = |part: &ModelPart| match &filter {
            Some((filter, _)) => filtered.filtered_material(part.material, *filter, scene),
            None => own.or(part.material),
        };
        let materials: Vec<Option<usize>> = parts.iter().map(material).collect();
        let of_object = |(part, material): (ModelPart, _)| ModelPart {
            material,
            casts: casts && part.casts,
            ..part
        };
        placed.push(PlacedObject {
            table,
            world_from_model: placement(table)?,
            local,
            receives: table.flag_or_true("receives")?,
            parts: parts.into_iter().zip(materials).map(of_object).collect(),
            item,
        });
    }
    textures.decode(&mut scene.textures)?;
    // Looks that need other vertices read a model again, with the same notices.
    let mut listed = HashSet::new();
    scene.notices.retain(|notice| listed.insert(notice.clone()));
    // Choose the anchor, and add an instance for each part.
    let anchor = anchor.unwrap_or_else(|eye| {
        let mut bounds = Box64::EMPTY;
        let corners = |object: &PlacedObject<'_>| object.local.corners(&object.world_from_model);
        placed
            .iter()
            .flat_map(corners)
            .for_each(|corner| bounds.add(corner));
        let anchor = bounds.anchor(eye);
        scene
            .notices
            .extend(far::notice(&tables[0].source.file, anchor));
        anchor
    });
    for object in &placed {
        object.add_instances(anchor, scene)?;
    }
    Ok(anchor)
}

/// An object in world space.
struct PlacedObject<'a> {
    table: &'a Table<'a>,
    /// The key that names the shape or the mesh.
    item: Item<'a>,
    world_from_model: DAffine3,
    /// The box of the model.
    local: Box64,
    receives: bool,
    /// Parts with the object's materials.
    parts: Vec<ModelPart>,
}

impl PlacedObject<'_> {
    fn add_instances(&self, anchor: Anchor, scene: &mut Scene) -> Result<(), SceneError> {
        check_size(self, anchor)?;
        for part in &self.parts {
            let world_from_local = part.placement_of(&self.world_from_model, anchor);
            scene.instances.push(Instance {
                mesh: part.mesh,
                world_from_local: not_flat(&self.item, world_from_local)?,
                casts: part.casts,
                receives: self.receives,
                material: part.material,
            });
        }
        Ok(())
    }
}

fn alpha_of(material: Option<usize>, scene: &Scene) -> Option<AlphaCutout> {
    scene.materials[material?].alpha
}

/// Materials of models whose alpha filter an object overrides, by the original material. Objects
/// without the key share the model with others.
#[derive(Debug, Default)]
struct FilteredMaterials {
    known: HashMap<usize, usize>,
}

impl FilteredMaterials {
    /// Returns the material of a part with this alpha filter.
    fn filtered_material(
        &mut self,
        material: Option<usize>,
        filter: AlphaFilter,
        scene: &mut Scene,
    ) -> Option<usize> {
        let alpha = alpha_of(material, scene).filter(|alpha| alpha.filter != filter);
        let (Some(material), Some(alpha)) = (material, alpha) else {
            return material;
        };
        // There are two filters, so one entry is enough for the other one.
        let place = self.known.entry(material).or_insert_with(|| {
            scene.materials.push(Material {
                alpha: Some(AlphaCutout { filter, ..alpha }),
                ..scene.materials[material]
            });
            scene.materials.len() - 1
        });
        Some(*place)
    }
}

/// Returns an error if 32-bit geometry is too coarse for an object's size, or for its position
/// relative to the anchor. The error names the key of the cause.
fn check_size(object: &PlacedObject<'_>, anchor: Anchor) -> Result<(), SceneError> {
    let PlacedObject {
        table,
        item: shape_or_mesh,
        world_from_model: place,
        local,
        ..
    } = object;
    let [least, most] = SIZES;
    let axes = [
        place.matrix3.x_axis,
        place.matrix3.y_axis,
        place.matrix3.z_axis,
    ];
    for (axis, local_size) in axes.into_iter().zip((local.max - local.min).to_array()) {
        // Skip an axis along which the object is flat.
        if local_size <= 0.0 {
            continue;
        }
        let size = axis.length() as f32 * local_size as f32;
        // NaN is outside every range.
        if !(least..=most).contains(&size) {
            let why = format!("makes the object {size:e} m across along one of its axes");
            let help = format!("use sizes from {least:e} to {most:e} m");
            let item = first_of(table, &["scale", "matrix"], shape_or_mesh);
            return Err(item.fault(&why, &help));
        }
    }
    let distances = local
        .corners(place)
        .map(|corner| anchor.position(corner).abs().max_element());
    let away = distances.into_iter().fold(0.0, f32::max);
    let origin = match anchor == Anchor::ORIGIN {
        true => "origin",
        false => "anchor",
    };
    let why = format!("puts the object {away:e} m from the {origin}");
    let help = format!("use positions within {most:e} m of it");
    let item = first_of(table, &["translate", "matrix", "scale"], shape_or_mesh);
    item.require(away <= most, &why, &help)
}

/// Returns the value of the first of these keys that the table has, or `otherwise`.
fn first_of<'a>(table: &Table<'a>, keys: &[&str], otherwise: &Item<'a>) -> Item<'a> {
    keys.iter()
        .find_map(|key| table.get(key))
        .unwrap_or_else(|| otherwise.clone())
}

/// Requirements of an object's look for its mesh. A model without requirements uses its own looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Needs {
    OwnLooks,
    Nothing,
    Coordinates,
    Tangents,
}

impl Needs {
    fn of_look(look: Option<&LookTable<'_>>) -> Self {
        match look {
            None => Self::OwnLooks,
            Some(look) if look.material.normal_map.is_some() => Self::Tangents,
            Some(look) if look.textured.is_some() => Self::Coordinates,
            Some(_) => Self::Nothing,
        }
    }

    fn is_textured(self) -> bool {
        matches!(self, Self::Coordinates | Self::Tangents)
    }
}

fn check_coordinates(
    look: Option<&LookTable<'_>>,
    parts: &[ModelPart],
    scene: &Scene,
) -> Result<(), SceneError> {
    let Some(item) = look.and_then(|look| look.textured.as_ref()) else {
        return Ok(());
    };
    let bare = parts
        .iter()
        .map(|part| &scene.meshes[part.mesh])
        .find(|mesh| mesh.uvs.is_empty());
    let why = bare.map(|mesh| format!("needs texture coordinates, and `{}` has none", mesh.name));
    item.require(
        why.is_none(),
        why.as_deref().unwrap_or(""),
        "export the model with them (`vt` lines of .obj files, TEXCOORD_0 of glTF)",
    )
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum MeshSource {
    Shape(String),
    Obj(PathBuf),
    Gltf(SceneOfFile),
}

impl MeshSource {
    /// Returns the model at a path. `None` if the name is not that of a model.
    fn model(path: PathBuf) -> Option<Self> {
        if let Some(wanted) = SceneOfFile::of_path(&path) {
            return Some(Self::Gltf(wanted));
        }
        let ending = path.extension()?;
        ending
            .eq_ignore_ascii_case("obj")
            .then_some(Self::Obj(path))
    }
}

fn shape_or_mesh<'a>(
    table: &Table<'a>,
    folder: &Path,
) -> Result<(MeshSource, Item<'a>), SceneError> {
    match (table.get("shape"), table.get("mesh")) {
        (Some(item), None) => Ok((MeshSource::Shape(item.word(SHAPES)?.to_owned()), item)),
        (None, Some(item)) => {
            let path = folder.join(item.text()?);
            let why = format!("is `{}`, not a .obj, .glb or .gltf file", path.display());
            let help = "name a model: Wavefront OBJ, or glTF 2.0";
            let source = MeshSource::model(path).ok_or_else(|| item.fault(&why, help))?;
            Ok((source, item))
        }
        (Some(_), Some(item)) => Err(item.fault("conflicts with `shape`", "keep one of the two")),
        (None, None) => Err(table.fault(
            "has neither `shape` nor `mesh`",
            "add shape = \"box\" or mesh = \"model.obj\"",
        )),
    }
}

fn make(
    source: &MeshSource,
    needs: &Needs,
    item: &Item<'_>,
    textures: &mut TextureFiles<'_>,
    scene: &mut Scene,
) -> Result<Vec<ModelPart>, SceneError> {
    let named = |fault| SceneError::Named {
        place: item.place(),
        fault: Box::new(fault),
    };
    let has_looks = *needs == Needs::OwnLooks;
    let parts = match source {
        MeshSource::Shape(name) => {
            scene.meshes.push(Mesh {
                name: name.clone(),
                ..shape(name, needs.is_textured())
            });
            vec![ModelPart::new(scene.meshes.len() - 1, None, DVec3::ZERO)]
        }
        MeshSource::Obj(path) => obj::add(path, textures, has_looks, scene).map_err(named)?,
        MeshSource::Gltf(wanted) => {
            gltf::add(wanted, textures.files, has_looks, scene).map_err(named)?
        }
    };
    if *needs != Needs::Tangents {
        return Ok(parts);
    }
    let meshes: BTreeSet<usize> = parts.iter().map(|part| part.mesh).collect();
    for mesh in meshes {
        let mesh = &mut scene.meshes[mesh];
        // Meshes without texture coordinates are refused by name later.
        if !mesh.uvs.is_empty() {
            *mesh = item.check(with_tangents(mesh))?;
        }
    }
    Ok(parts)
}

/// Returns a plane, a box or a sphere from -1 to 1. A sphere only has texture coordinates if
/// requested, since they double vertices.
fn shape(name: &str, textured: bool) -> Mesh {
    match name {
        "plane" => grid([1.0, 1.0], [1, 1], |_, _| 0.0),
        "box" => block(Vec3::NEG_ONE, Vec3::ONE),
        _ => {
            let sphere = icosphere(Vec3::ZERO, 1.0, SPHERE_SPLITS);
            if textured { map_mesh(&sphere) } else { sphere }
        }
    }
}

fn placement(table: &Table<'_>) -> Result<DAffine3, SceneError> {
    let steps = ["translate", "rotate_degrees", "scale"].map(|key| table.get(key));
    let Some(item) = table.get("matrix") else {
        return from_steps(&steps);
    };
    if let Some(other) = steps.iter().flatten().next() {
        return Err(other.fault(
            "conflicts with `matrix`",
            "keep either the matrix or the steps",
        ));
    }
    let mut rows = Vec::with_capacity(4);
    for item in item.list(4, "four rows of four numbers")? {
        rows.push(row(&item)?);
    }
    let matrix = DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose();
    item.require(
        rows[3] == DVec4::W,
        &format!("ends in the row {}", rows[3]),
        "end it in [0, 0, 0, 1]",
    )?;
    let place = DAffine3::from_mat4(matrix);
    let rounded = place.as_affine3a();
    item.check(invalid::finite("", &rounded.to_cols_array()))?;
    not_flat(&item, rounded)?;
    Ok(place)
}

fn row(item: &Item<'_>) -> Result<DVec4, SceneError> {
    let mut numbers = Vec::with_capacity(4);
    for item in item.list(4, "rows of four numbers")? {
        numbers.push(item.wide_number()?);
    }
    Ok(DVec4::from_slice(&numbers))
}

/// Returns the placement: scale first, then turns about x, y and z in this order, then the
/// translation.
fn from_steps(steps: &[Option<Item<'_>>; 3]) -> Result<DAffine3, SceneError> {
    let [translate, rotate, scale] = steps;
    let degrees = match rotate {
        Some(item) => item.vec3()?,
        None => Vec3::ZERO,
    };
    let angles = degrees * std::f32::consts::PI / 180.0;
    let turn = Quat::from_euler(EulerRot::XYZEx, angles.x, angles.y, angles.z);
    let size = match scale {
        Some(item) => scale_of(item)?,
        None => Vec3::ONE,
    };
    let position = match translate {
        Some(item) => {
            item.position(Anchor::ORIGIN)?;
            item.wide_vec3()?
        }
        None => DVec3::ZERO,
    };
    let turned = Affine3A::from_scale_rotation_translation(size, turn, Vec3::ZERO);
    if let Some(item) = scale {
        not_flat(item, turned)?;
    }
    Ok(DAffine3 {
        translation: position,
        ..turned.as_daffine3()
    })
}

/// Reads one number for all axes, or one for each.
fn scale_of(item: &Item<'_>) -> Result<Vec3, SceneError> {
    if item.value.is_array() {
        item.vec3()
    } else {
        item.number().map(Vec3::splat)
    }
}

fn not_flat(item: &Item<'_>, place: Affine3A) -> Result<Affine3A, SceneError> {
    let flat = place.matrix3.as_dmat3().determinant() == 0.0;
    item.require(!flat, "flattens the object", "use sizes other than zero")?;
    Ok(place)
}
