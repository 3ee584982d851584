//! Poses of meshes: morph targets at the weights of the file, and skins at its joints. Animations
//! are ignored, so both are in their rest pose.

use super::{
    accessor::AccessorNumbers,
    document::{broken_element, element_name},
    file_bytes::FileBytes,
    nodes::PlacedNode,
    primitive::PrimitiveShape,
};
use gltf::{Primitive, Semantic, Skin};
use std::collections::HashMap;
use umbrage_core::Invalid;
use umbrage_core::glam::{DAffine3, DMat4, DVec3, Vec3};

/// The pose in which a node shows a mesh.
#[derive(Clone, Debug, Default)]
pub(super) struct Pose {
    /// Weights of the morph targets.
    pub(super) weights: Vec<f32>,
    /// The skin's number and its matrices: scene from mesh, for each joint.
    pub(super) skin: Option<(usize, Vec<DAffine3>)>,
}

impl Pose {
    /// Returns the pose of a node's mesh. `joints` has the placements of the scene's nodes. A skin
    /// with a joint outside of the scene is ignored, with a notice.
    pub(super) fn of_node(
        node: &PlacedNode<'_>,
        joints: &HashMap<usize, DAffine3>,
        data: &mut FileBytes<'_>,
        notices: &mut Vec<String>,
    ) -> Result<Self, Invalid> {
        let of_mesh = node.node.mesh().and_then(|mesh| mesh.weights());
        let weights = node.node.weights().or(of_mesh).unwrap_or_default().to_vec();
        if let Some(bad) = weights.iter().find(|weight| !weight.is_finite()) {
            return Err(broken_element("its weights", format!("hold {bad}")));
        }
        let Some(skin) = node.node.skin() else {
            return Ok(Self {
                weights,
                skin: None,
            });
        };
        let name = element_name("skin", skin.index(), skin.name());
        let matrices = joint_matrices(&skin, joints, data).map_err(|e| e.within_context(&name))?;
        if matrices.is_none() {
            let notice = format!("{name} is ignored: a joint is not in the scene");
            if !notices.contains(&notice) {
                notices.push(notice);
            }
        }
        Ok(Self {
            weights,
            skin: matrices.map(|matrices| (skin.index(), matrices)),
        })
    }

    /// Returns the pose as a key, equal for equal poses of one file.
    pub(super) fn key(&self) -> (Vec<u32>, Option<usize>) {
        let weights = self.weights.iter().map(|weight| weight.to_bits()).collect();
        (weights, self.skin.as_ref().map(|(index, _)| *index))
    }

    /// Moves the vertices of a primitive. Returns `true` if joints move them.
    pub(super) fn apply(
        &self,
        primitive: &Primitive<'_>,
        shape: &PrimitiveShape,
        positions: &mut [DVec3],
        normals: &mut [Vec3],
        data: &mut FileBytes<'_>,
    ) -> Result<bool, Invalid> {
        self.morph(primitive, shape, positions, normals, data)?;
        self.skin(primitive, shape, positions, normals, data)
    }

    fn morph(
        &self,
        primitive: &Primitive<'_>,
        shape: &PrimitiveShape,
        positions: &mut [DVec3],
        normals: &mut [Vec3],
        data: &mut FileBytes<'_>,
    ) -> Result<(), Invalid> {
        for (target, &weight) in primitive.morph_targets().zip(&self.weights) {
            if weight == 0.0 {
                continue;
            }
            if let Some(accessor) = target.positions() {
                let offsets = shape.vectors::<3>(accessor, data)?;
                for (position, offset) in positions.iter_mut().zip(offsets) {
                    *position += f64::from(weight) * Vec3::from_array(offset).as_dvec3();
                }
            }
            if let Some(accessor) = target.normals().filter(|_| !normals.is_empty()) {
                let offsets = shape.vectors::<3>(accessor, data)?;
                for (normal, offset) in normals.iter_mut().zip(offsets) {
                    *normal += weight * Vec3::from_array(offset);
                }
            }
        }
        Ok(())
    }

    /// Moves vertices with the joints. Returns `false` if the pose has no skin.
    fn skin(
        &self,
        primitive: &Primitive<'_>,
        shape: &PrimitiveShape,
        positions: &mut [DVec3],
        normals: &mut [Vec3],
        data: &mut FileBytes<'_>,
    ) -> Result<bool, Invalid> {
        let Some((_, matrices)) = &self.skin else {
            return Ok(false);
        };
        let mut sums = vec![(DMat4::ZERO, 0.0); positions.len()];
        for set in 0.. {
            let joints = shape.attribute::<4>(primitive, &Semantic::Joints(set), data)?;
            let weights = shape.attribute::<4>(primitive, &Semantic::Weights(set), data)?;
            if joints.is_empty() || weights.is_empty() {
                break;
            }
            for (sum, (joints, weights)) in sums.iter_mut().zip(joints.iter().zip(&weights)) {
                for (&joint, &weight) in joints.iter().zip(weights) {
                    if weight == 0.0 {
                        continue;
                    }
                    let matrix = matrices.get(joint as usize).ok_or_else(|| {
                        let why = format!("name joint {joint} of {}", matrices.len());
                        broken_element("its joints", why)
                    })?;
                    sum.0 += DMat4::from(*matrix) * f64::from(weight);
                    sum.1 += f64::from(weight);
                }
            }
        }
        for (i, (sum, weight)) in sums.into_iter().enumerate() {
            if weight == 0.0 {
                return Err(broken_element(
                    "its weights",
                    format!("are all zero at vertex {i}"),
                ));
            }
            // Sums of weights are 1, except for rounding.
            let matrix = DAffine3::from_mat4(sum * weight.recip());
            positions[i] = matrix.transform_point3(positions[i]);
            if let Some(normal) = normals.get_mut(i) {
                let turned = matrix.matrix3.inverse().transpose() * normal.as_dvec3();
                *normal = turned.normalize_or(DVec3::ZERO).as_vec3();
            }
        }
        if let Some(bad) = positions.iter().find(|position| !position.is_finite()) {
            return Err(broken_element(
                "its skin",
                format!("moves a vertex to {bad}"),
            ));
        }
        Ok(true)
    }
}

/// Returns the matrices of a skin's joints. `None` if a joint is not in the scene.
fn joint_matrices(
    skin: &Skin<'_>,
    joints: &HashMap<usize, DAffine3>,
    data: &mut FileBytes<'_>,
) -> Result<Option<Vec<DAffine3>>, Invalid> {
    let places: Option<Vec<DAffine3>> = skin
        .joints()
        .map(|joint| joints.get(&joint.index()).copied())
        .collect();
    let Some(mut places) = places else {
        return Ok(None);
    };
    let Some(accessor) = skin.inverse_bind_matrices() else {
        return Ok(Some(places));
    };
    let inverses = AccessorNumbers::open(accessor, data)?;
    if inverses.count() < places.len() {
        let (count, joints) = (inverses.count(), places.len());
        return Err(inverses.fault(format!("has {count} matrices for {joints} joints")));
    }
    for (place, inverse) in places.iter_mut().zip(inverses.matrices(data)?) {
        let inverse = DMat4::from_cols_array(&inverse.map(f64::from));
        *place *= DAffine3::from_mat4(inverse);
    }
    Ok(Some(places))
}
