//! Casters that the program draws itself into the set's layers, such as skinned meshes.

use crate::light_set::{
    casters::Casters,
    culling::{Volume, gap},
    ids::OwnCasterKey,
    unknown,
};
use glam::Vec3;
use slotmap::SlotMap;
use umbrage_core::{Aabb, Invalid};

/// The world-space boxes of the program's own casters.
#[derive(Debug, Default)]
pub(crate) struct OwnCasters(SlotMap<OwnCasterKey, Aabb>);

impl OwnCasters {
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(crate) fn count(&self) -> usize {
        self.0.len()
    }

    /// Returns the box around all of them.
    pub(crate) fn bounds(&self) -> Aabb {
        self.0.values().fold(Aabb::EMPTY, |all, one| all.union(one))
    }

    /// Returns the distance from a point to the nearest box, less its rounding, metres; infinite
    /// without boxes.
    pub(crate) fn distance_from(&self, point: Vec3) -> f32 {
        let distance = |bounds: &Aabb| {
            let (centre, half) = (bounds.center(), bounds.extent() * 0.5);
            let outside = |axis: usize| gap(point[axis], centre[axis], half[axis]);
            Vec3::new(outside(0), outside(1), outside(2)).length()
        };
        self.0.values().map(distance).fold(f32::INFINITY, f32::min)
    }

    /// Returns those that may be visible in a layer.
    pub(crate) fn shown_in(&self, layer: &Volume) -> impl Iterator<Item = OwnCasterKey> {
        let shown = self.0.iter().filter(|(_, bounds)| layer.may_show(bounds));
        shown.map(|(id, _)| id)
    }
}

impl Casters {
    pub(crate) fn own(&self) -> &OwnCasters {
        &self.own
    }

    pub(crate) fn add_own(&mut self, bounds: Aabb) -> Result<OwnCasterKey, Invalid> {
        check(&bounds)?;
        // With the first one, the device can no longer build hierarchies.
        self.has_grown = true;
        self.changed.push(bounds);
        Ok(self.own.0.insert(bounds))
    }

    pub(crate) fn move_own(&mut self, id: OwnCasterKey, bounds: Aabb) -> Result<(), Invalid> {
        check(&bounds)?;
        let held = self.own.0.get_mut(id).ok_or_else(unknown_caster)?;
        // The pose may differ within the same box.
        self.changed.push(std::mem::replace(held, bounds));
        self.changed.push(bounds);
        Ok(())
    }

    /// Sets a box without recording a change: everything is redrawn.
    pub(crate) fn rebase_own(&mut self, id: OwnCasterKey, bounds: Aabb) -> Result<(), Invalid> {
        check(&bounds)?;
        *self.own.0.get_mut(id).ok_or_else(unknown_caster)? = bounds;
        self.is_rebased = true;
        Ok(())
    }

    pub(crate) fn remove_own(&mut self, id: OwnCasterKey) -> Result<(), Invalid> {
        let bounds = self.own.0.remove(id).ok_or_else(unknown_caster)?;
        self.has_grown = true;
        self.changed.push(bounds);
        Ok(())
    }
}

fn check(bounds: &Aabb) -> Result<(), Invalid> {
    let within = |e: Invalid| e.within_context("own caster");
    bounds.validate().map_err(within)?;
    if bounds.is_empty() {
        let help = "use the world-space box around the figure in its current pose";
        return Err(within(Invalid::new("bounds", "are empty", help)));
    }
    Ok(())
}

fn unknown_caster() -> Invalid {
    unknown("own caster")
}
