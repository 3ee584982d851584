//! Serialization of placed triangles, for transfer between threads or processes.

use crate::geometry::{Geometry, cut_out::CutOuts, placed::PlacedMeshes};
use crate::invalid::Invalid;
use glam::{Vec2, Vec3, Vec4};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error as _};
use std::{borrow::Cow, ops::Range, sync::Arc};

/// The serialized part of a geometry; the rest is derived from it.
#[derive(Serialize, Deserialize)]
struct GeometryData<'a> {
    positions: Cow<'a, [Vec3]>,
    normals: Cow<'a, [Vec3]>,
    uvs: Cow<'a, [Vec2]>,
    tangents: Cow<'a, [Vec4]>,
    triangles: Cow<'a, [[u32; 3]]>,
    materials: Cow<'a, [u32]>,
    casters: Range<u32>,
    receivers: Range<u32>,
    /// The table of [`CutOuts`]; empty if all triangles are opaque.
    cut_outs: Cow<'a, [[u32; 4]]>,
    /// The table of mipmapped coverages; empty if there is none.
    coverage: Cow<'a, [[u32; 4]]>,
}

impl Serialize for Geometry {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let data = GeometryData {
            positions: self.positions().into(),
            normals: self.normals().into(),
            uvs: self.uvs().into(),
            tangents: self.tangents().into(),
            triangles: self.triangles().into(),
            materials: self.materials().into(),
            casters: self.casters(),
            receivers: self.receivers(),
            cut_outs: match self.cut_outs() {
                Some(cut_outs) => Cow::Borrowed(&**cut_outs.rows()),
                None => Cow::default(),
            },
            coverage: match self.cut_outs().and_then(|c| c.coverage_rows()) {
                Some(rows) => Cow::Borrowed(&**rows),
                None => Cow::default(),
            },
        };
        data.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Geometry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let data = GeometryData::deserialize(deserializer)?;
        data.validate().map_err(D::Error::custom)?;
        let cut_outs = CutOuts::from_rows(&data.cut_outs, &data.coverage, data.triangles.len());
        let cut_outs = cut_outs.map_err(D::Error::custom)?;
        let mut placed = PlacedMeshes {
            positions: data.positions.into_owned(),
            normals: data.normals.into_owned(),
            uvs: data.uvs.into_owned(),
            tangents: data.tangents.into_owned(),
            triangles: data.triangles.into_owned(),
            materials: data.materials.into_owned(),
            hash: 0,
        };
        placed.finish();
        let mut out = Self {
            placed: Arc::new(placed),
            casters: data.casters,
            receivers: data.receivers,
            cut_outs,
            ..Self::default()
        };
        out.fingerprint = out.hash();
        Ok(out)
    }
}

impl GeometryData<'_> {
    /// Errors if [`Geometry::bake`] could not have made this geometry.
    fn validate(&self) -> Result<(), Invalid> {
        let bad = |why: String| Invalid::new("geometry", why, "write it again");
        let (vertices, triangles) = (self.positions.len(), self.triangles.len());
        for (what, count, of) in [
            ("normals", self.normals.len(), vertices),
            ("texture coordinates", self.uvs.len(), vertices),
            ("tangents", self.tangents.len(), vertices),
            ("materials", self.materials.len(), triangles),
        ] {
            let may_be_missing = what != "normals";
            if count != of && !(may_be_missing && count == 0) {
                return Err(bad(format!("has {count} {what} for {of}")));
            }
        }
        if let Some(position) = self.positions.iter().find(|p| !p.is_finite()) {
            return Err(bad(format!("has a vertex at {position}")));
        }
        let corners = self.triangles.iter().flatten();
        if let Some(corner) = corners.max().filter(|&&v| v as usize >= vertices) {
            return Err(bad(format!(
                "names vertex {corner}, but there are {vertices}"
            )));
        }
        for (what, run) in [("casters", &self.casters), ("receivers", &self.receivers)] {
            if run.start > run.end || run.end as usize > triangles {
                return Err(bad(format!(
                    "has {what} {run:?}, but {triangles} triangles"
                )));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Instance, Mesh, Scene};
    use glam::Affine3A;

    fn geometry() -> Geometry {
        let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        let plain = Mesh::new("plain", corners.clone(), vec![[0, 1, 2]]).unwrap();
        let mapped = Mesh {
            uvs: vec![Vec2::ZERO, Vec2::X, Vec2::Y],
            tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 3],
            ..plain.clone()
        };
        let mut painted = Instance::new(1, Affine3A::from_translation(Vec3::new(0.1, -0.0, 3.0)));
        painted.material = Some(0);
        let floor = Instance {
            casts: false,
            ..Instance::new(0, Affine3A::IDENTITY)
        };
        let scene = Scene {
            meshes: vec![plain, mapped],
            instances: vec![floor, painted],
            materials: vec![Default::default()],
            ..Scene::default()
        };
        Geometry::bake(&scene).unwrap()
    }

    fn value(geometry: &Geometry) -> serde_json::Value {
        serde_json::to_value(geometry).unwrap()
    }

    #[test]
    fn what_is_read_back_is_the_same() {
        for geometry in [
            geometry(),
            geometry().without_casters(),
            Geometry::default(),
        ] {
            // Hierarchies are not part of the data.
            geometry.bvh();
            let read: Geometry = serde_json::from_value(value(&geometry)).unwrap();
            assert_eq!(value(&read), value(&geometry));
            assert_eq!(read.uvs(), geometry.uvs());
            assert_eq!(read.tangents(), geometry.tangents());
            assert_eq!(read.materials(), geometry.materials());
            if !geometry.triangles().is_empty() {
                assert_eq!(read.fingerprint(), geometry.fingerprint());
            }
        }
    }

    #[test]
    fn what_could_not_have_been_placed_is_refused() {
        let refused = |key: &str, spoilt: serde_json::Value| {
            let mut value = value(&geometry());
            value[key] = spoilt;
            let read = serde_json::from_value::<Geometry>(value);
            read.unwrap_err().to_string()
        };
        let json = |text: &str| serde_json::from_str(text).unwrap();
        assert!(refused("normals", json("[]")).contains("has 0 normals for 6"));
        assert!(refused("uvs", json("[[0, 0]]")).contains("has 1 texture coordinates for 6"));
        assert!(refused("materials", json("[0]")).contains("has 1 materials for 2"));
        assert!(refused("positions", json("[[0, 0, 1e39]]")).contains("normals"));
        assert!(refused("triangles", json("[[0, 1, 6], [0, 1, 2]]")).contains("names vertex 6"));
        assert!(refused("casters", json(r#"{"start": 0, "end": 3}"#)).contains("has casters 0..3"));
        assert!(refused("receivers", json(r#"{"start": 2, "end": 1}"#)).contains("receivers 2..1"));
    }

    #[test]
    fn places_that_are_not_finite_are_refused() {
        let mut data = GeometryData {
            positions: vec![Vec3::ZERO].into(),
            normals: vec![Vec3::ZERO].into(),
            uvs: Cow::default(),
            tangents: Cow::default(),
            triangles: Cow::default(),
            materials: Cow::default(),
            casters: 0..0,
            receivers: 0..0,
            cut_outs: Cow::default(),
            coverage: Cow::default(),
        };
        assert!(data.validate().is_ok());
        data.positions.to_mut()[0].x = f32::NAN;
        assert!(data.validate().is_err());
    }
}
