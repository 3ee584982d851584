//! Instances of a node's mesh: `EXT_mesh_gpu_instancing`.

use super::{accessor::AccessorNumbers, document::broken_element, file_bytes::FileBytes};
use gltf::{Document, Node};
use umbrage_core::Invalid;
use umbrage_core::glam::{DAffine3, DQuat, DVec3};

/// Returns the placements in the node of its mesh's instances. A node without the extension has
/// one.
pub(super) fn instances(
    node: &Node<'_>,
    document: &Document,
    data: &mut FileBytes<'_>,
) -> Result<Vec<DAffine3>, Invalid> {
    let Some(extension) = node.extension_value("EXT_mesh_gpu_instancing") else {
        return Ok(vec![DAffine3::IDENTITY]);
    };
    let mut open = |name: &str| {
        let Some(value) = extension["attributes"].get(name) else {
            return Ok(None);
        };
        let index = value.as_u64().and_then(|index| usize::try_from(index).ok());
        let accessor = index.and_then(|index| document.accessors().nth(index));
        let Some(accessor) = accessor else {
            let what = format!("EXT_mesh_gpu_instancing, {name}");
            return Err(broken_element(what, "points to a missing element"));
        };
        AccessorNumbers::open(accessor, data).map(Some)
    };
    let attributes = [open("TRANSLATION")?, open("ROTATION")?, open("SCALE")?];
    let mut counts = attributes.iter().flatten().map(AccessorNumbers::count);
    let count = counts.next().unwrap_or(0);
    if let Some(other) = counts.find(|other| *other != count) {
        let why = format!("has attributes of {count} and of {other} instances");
        return Err(broken_element("EXT_mesh_gpu_instancing", why));
    }
    let [translations, rotations, scales] = &attributes;
    let mut out = vec![(DVec3::ZERO, DQuat::IDENTITY, DVec3::ONE); count];
    if let Some(accessor) = translations {
        for (place, translation) in out.iter_mut().zip(accessor.vectors::<3>(None, data)?) {
            place.0 = DVec3::from_array(translation.map(f64::from));
        }
    }
    if let Some(accessor) = rotations {
        for (place, rotation) in out.iter_mut().zip(accessor.vectors::<4>(None, data)?) {
            let rotation = DQuat::from_array(rotation.map(f64::from));
            if rotation.length_squared() == 0.0 {
                return Err(accessor.fault("holds a rotation of zero, which is not a quaternion"));
            }
            place.1 = rotation.normalize();
        }
    }
    if let Some(accessor) = scales {
        for (place, scale) in out.iter_mut().zip(accessor.vectors::<3>(None, data)?) {
            place.2 = DVec3::from_array(scale.map(f64::from));
        }
    }
    let place = |(translation, rotation, scale)| {
        DAffine3::from_scale_rotation_translation(scale, rotation, translation)
    };
    Ok(out.into_iter().map(place).collect())
}
