//! The tree of nodes, and their placements.

use super::document::{broken_element, element_name};
use gltf::{Document, Node, Scene, scene::Transform};
use serde_json::Value;
use std::collections::HashMap;
use umbrage_core::glam::{DAffine3, DMat4, DQuat, DVec3, DVec4, Mat3A, Vec3};
use umbrage_core::{Invalid, invalid::finite};

/// A node of the chosen scene, and its placement.
#[derive(Clone, Debug)]
pub(super) struct PlacedNode<'a> {
    pub(super) node: Node<'a>,
    /// Placement, multiplied in 64 bits from the root down.
    pub(super) world_from_node: DAffine3,
    /// `false` if the node or one above it is hidden (`KHR_node_visibility`).
    pub(super) is_visible: bool,
}

impl PlacedNode<'_> {
    /// Returns the node's name for errors.
    pub(super) fn error_name(&self) -> String {
        element_name("node", self.node.index(), self.node.name())
    }

    /// Returns where the node places a mesh, `node_from_mesh` from the node. `None` if sizes of
    /// zero flatten the mesh. Zero along all axes hides it; along some, `notices` has a line.
    pub(super) fn placement(
        &self,
        node_from_mesh: DAffine3,
        notices: &mut Vec<String>,
    ) -> Result<Option<DAffine3>, Invalid> {
        let world_from_mesh = self.world_from_node * node_from_mesh;
        let place = world_from_mesh.as_affine3a();
        if place.matrix3 == Mat3A::ZERO {
            return Ok(None);
        }
        finite("its world transform", &place.to_cols_array())?;
        if place.matrix3.as_dmat3().determinant() == 0.0 {
            let name = self.error_name();
            let notice = format!("{name} is ignored: a size of zero flattens its mesh");
            if !notices.contains(&notice) {
                notices.push(notice);
            }
            return Ok(None);
        }
        Ok(Some(world_from_mesh))
    }

    /// Returns the position of the node's origin.
    pub(super) fn position(&self) -> Result<Vec3, Invalid> {
        let position = self.world_from_node.translation.as_vec3();
        finite("its world transform", &position.to_array())?;
        Ok(position)
    }

    /// Returns the world direction of a local direction, as a unit vector, ignoring scales.
    pub(super) fn direction(&self, local: DVec3) -> Result<Vec3, Invalid> {
        let direction = self.world_from_node.transform_vector3(local);
        direction
            .try_normalize()
            .map(|unit| unit.as_vec3())
            .ok_or_else(|| {
                Invalid::new(
                    "its world transform",
                    "has no direction: a size is zero, or out of range",
                    "use sizes other than zero for nodes with cameras and lights",
                )
            })
    }
}

/// Returns the nodes of a scene, each after its parent and in the order of the file. `json` has the
/// nodes of files far from the origin, whose translations are read with 64 bits.
pub(super) fn placed_nodes<'a>(
    document: &'a Document,
    scene: Scene<'a>,
    json: &[Value],
) -> Result<Vec<PlacedNode<'a>>, Invalid> {
    // The parents of nodes; `None` for roots.
    let mut parents: HashMap<usize, Option<usize>> = HashMap::new();
    let mut out = Vec::new();
    // Visit the last node next.
    let roots = scene
        .nodes()
        .map(|node| (node, DAffine3::IDENTITY, true, None));
    let mut open: Vec<(Node<'a>, DAffine3, bool, Option<usize>)> = roots.collect();
    open.reverse();
    while let Some((node, world_from_parent, is_parent_visible, parent)) = open.pop() {
        let index = node.index();
        if parents.contains_key(&index) {
            return Err(reached_again(document, &parents, &node, parent));
        }
        parents.insert(index, parent);
        let parent_from_node = transform(&node)
            .map(|place| with_wide_translation(place, json.get(index)))
            .map_err(|e| e.within_context(element_name("node", index, node.name())))?;
        let world_from_node = world_from_parent * parent_from_node;
        let is_visible = is_parent_visible && !is_hidden(&node);
        let first = open.len();
        let children = node.children();
        open.extend(children.map(|child| (child, world_from_node, is_visible, Some(index))));
        open[first..].reverse();
        out.push(PlacedNode {
            node,
            world_from_node,
            is_visible,
        });
    }
    Ok(out)
}

/// Returns a placement with the translation of the node's JSON, if there is one.
fn with_wide_translation(place: DAffine3, json: Option<&Value>) -> DAffine3 {
    let numbers = |node: &Value| {
        let translation = match node.get("matrix") {
            Some(matrix) => matrix.as_array()?.get(12..15)?.to_vec(),
            None => node.get("translation")?.as_array()?.clone(),
        };
        let numbers: Option<Vec<f64>> = translation.iter().map(Value::as_f64).collect();
        numbers.filter(|numbers| numbers.len() == 3)
    };
    match json.and_then(numbers) {
        Some(numbers) => DAffine3 {
            translation: DVec3::from_slice(&numbers),
            ..place
        },
        None => place,
    }
}

/// Reports whether a node hides itself and all nodes below it.
fn is_hidden(node: &Node<'_>) -> bool {
    node.extension_value("KHR_node_visibility")
        .is_some_and(|visibility| visibility["visible"] == false)
}

/// Returns the error of a node that is reached a second time, from another parent or from one of
/// its descendants.
fn reached_again(
    document: &Document,
    parents: &HashMap<usize, Option<usize>>,
    node: &Node<'_>,
    second: Option<usize>,
) -> Invalid {
    let name = |parent: Option<usize>| match parent {
        Some(parent) => {
            let name = document.nodes().nth(parent).and_then(|node| node.name());
            element_name("node", parent, name)
        }
        None => "the scene".to_owned(),
    };
    let first = parents[&node.index()];
    // Parents were reached before their children, so this loop ends.
    let mut ancestors = std::iter::successors(second, |parent| parents[parent]);
    let why = if ancestors.any(|ancestor| ancestor == node.index()) {
        format!("is below itself: it is a child of {}", name(second))
    } else if first == second {
        format!("is listed twice by {}", name(second))
    } else {
        format!("has two parents: {} and {}", name(first), name(second))
    };
    let what = element_name("node", node.index(), node.name());
    Invalid::new(
        what,
        why,
        "list each node once, below one parent; copies need separate nodes",
    )
}

/// Returns the placement of a node in its parent.
fn transform(node: &Node<'_>) -> Result<DAffine3, Invalid> {
    match node.transform() {
        Transform::Matrix { matrix } => {
            finite("matrix", matrix.as_flattened())?;
            let matrix = DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from)));
            if matrix.row(3) != DVec4::W {
                return Err(broken_element(
                    "matrix",
                    format!("ends in the row {}, not in [0, 0, 0, 1]", matrix.row(3)),
                ));
            }
            Ok(DAffine3::from_mat4(matrix))
        }
        Transform::Decomposed {
            translation,
            rotation,
            scale,
        } => {
            finite("translation", &translation)?;
            finite("rotation", &rotation)?;
            finite("scale", &scale)?;
            let rotation = DQuat::from_array(rotation.map(f64::from));
            if rotation.length_squared() == 0.0 {
                return Err(broken_element(
                    "rotation",
                    "is zero, which is not a quaternion",
                ));
            }
            Ok(DAffine3::from_scale_rotation_translation(
                DVec3::from_array(scale.map(f64::from)),
                rotation.normalize(),
                DVec3::from_array(translation.map(f64::from)),
            ))
        }
    }
}
