//! All that the program does with the library: casters and lights of a light set, and what is changed in it.

use crate::{
    meshes::Meshes,
    scene::{self, Lamp, Object},
    settings::Settings,
};
use anyhow::Result;
use umbrage::{
    Camera,
    techniques::TechniqueEntry,
    wgpu::{
        CasterId, CasterMesh, Indices, LightId, LightSet, LightSetOptions, PositionFormat,
        SetFrame, SetLight, VertexLayout,
    },
};

/// The bind group of the light set in the program's forward shader; the program's own is 0.
pub const GROUP: u32 = 1;

/// A light set with the scene's casters and lamps.
pub struct SceneShadows {
    pub set: LightSet,
    /// In the order of the scene's objects.
    casters: Vec<CasterId>,
    /// In the order of `lamps`, which is that of their indices in shaders.
    pub lights: Vec<LightId>,
    pub lamps: Vec<Lamp>,
    /// Those that the lights have.
    settings: Settings,
}

impl SceneShadows {
    /// Puts the scene into a light set. The buffers are those that the program draws from itself.
    pub fn new(
        device: &wgpu::Device,
        meshes: &Meshes,
        vertices: &wgpu::Buffer,
        indices: &wgpu::Buffer,
        objects: &[Object],
        settings: &Settings,
    ) -> Result<Self> {
        let options = LightSetOptions {
            group: GROUP,
            ..LightSetOptions::default()
        };
        let mut set = LightSet::new(device, options)?;
        let mut mesh_ids = Vec::new();
        for mesh in &meshes.meshes {
            mesh_ids.push(set.add_mesh(&CasterMesh {
                label: mesh.label,
                vertices,
                layout: VertexLayout {
                    format: PositionFormat::Float32x3,
                    stride: size_of::<crate::meshes::Vertex>() as u64,
                    position_offset: 0,
                },
                indices: Some(Indices {
                    buffer: indices,
                    format: wgpu::IndexFormat::Uint16,
                }),
                range: mesh.indices.clone(),
                base_vertex: mesh.base_vertex,
                bounds: mesh.bounds,
            })?);
        }
        let mut casters = Vec::new();
        for object in objects {
            let mesh = mesh_ids[object.shape as usize];
            casters.push(set.add_caster(mesh, object.place(0.0))?);
        }
        let mut lights = Vec::new();
        let lamps = scene::lamps();
        for lamp in &lamps {
            lights.push(set.add_light(SetLight {
                light: lamp.light,
                technique: settings.technique(lamp),
                // The sun comes first where not all can be served.
                priority: if lamp.range.is_finite() { 1.0 } else { 10.0 },
            })?);
        }
        Ok(Self {
            set,
            casters,
            lights,
            lamps,
            settings: settings.clone(),
        })
    }

    /// Takes what changed in the panel.
    pub fn apply(&mut self, settings: &Settings) -> Result<()> {
        if *settings == self.settings {
            return Ok(());
        }
        self.lamps[0] = scene::sun(settings.sun_perspective);
        for (&id, lamp) in self.lights.iter().zip(&self.lamps) {
            self.set.set_light(id, lamp.light)?;
            self.set.set_technique(id, settings.technique(lamp))?;
        }
        self.settings = settings.clone();
        Ok(())
    }

    /// Moves the casters to where the objects are after some seconds.
    pub fn place(&mut self, objects: &[Object], seconds: f32) -> Result<()> {
        for (&caster, object) in self.casters.iter().zip(objects) {
            self.set.move_caster(caster, object.place(seconds))?;
        }
        Ok(())
    }

    /// Returns why the set can't serve all lamps with a technique; none if it can.
    pub fn refusal(&self, technique: &TechniqueEntry, camera: &Camera) -> Option<String> {
        let frame = SetFrame {
            camera,
            geometry: None,
        };
        self.lamps.iter().find_map(|lamp| {
            let candidate = self.settings.candidate(technique, lamp);
            let checked = self.set.check(&lamp.light, &*candidate, &frame);
            checked.err().map(|error| error.to_string())
        })
    }

    /// Returns why lamps have no shadows, each reason once, with how many have it.
    pub fn unserved(&self) -> Vec<(String, usize)> {
        let mut out: Vec<(String, usize)> = Vec::new();
        for (_, why) in self.set.unserved() {
            let why = why.to_string();
            match out.iter_mut().find(|(known, _)| *known == why) {
                Some((_, count)) => *count += 1,
                None => out.push((why, 1)),
            }
        }
        out
    }
}
