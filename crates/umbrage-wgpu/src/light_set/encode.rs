//! Recording of a frame's passes.

use crate::{
    light_set::{
        LightSet,
        ids::{LightKey, OwnCasterId},
        masks,
        passes::OwnDraws,
        shader::unprepared_error,
        timestamps::{PassCasters, PassClock, PassTimer, SetPass, SetTimestamps, TimedPass},
    },
    targets::CastTarget,
};
use umbrage_core::{BackendError, Invalid};
use wgpu::{CommandEncoder, RenderPass, TextureView};

impl LightSet {
    /// Records the passes that [`prepare`](Self::prepare) selected; no passes if nothing changed.
    ///
    /// # Errors
    /// Errors if [`prepare`](Self::prepare) has not succeeded before, or if there are casters that
    /// the program draws: use [`encode_with`](Self::encode_with).
    pub fn encode(&mut self, encoder: &mut CommandEncoder) -> Result<(), BackendError> {
        let own = self.casters.own().count();
        if own > 0 {
            let why = format!("has {own} casters that the program draws");
            return Err(Invalid::new("light set", why, "use `encode_with`, and draw them").into());
        }
        self.encode_passes(encoder, &mut |_, _, _| (), None)
    }

    /// Records the passes like [`encode`](Self::encode). Calls `own_draws` at the end of each pass
    /// with casters that the program draws ([`add_own_caster`](Self::add_own_caster)), with the ids
    /// of those that may be visible in the layer.
    ///
    /// Pipelines need the target's [`primitive`](CastTarget::primitive) and
    /// [`depth_stencil`](CastTarget::depth_stencil). Targets with equal
    /// [keys](CastTarget::key) need equal ones. The vertex shader ends in
    /// `clip_from_world * p_world`: the pass has this matrix at bind group 0
    /// ([`cast_layout`](Self::cast_layout)). If the target has a layer to peel
    /// ([`behind`](CastTarget::behind)), the pass has it at group 2.
    ///
    /// # Errors
    /// Errors if [`prepare`](Self::prepare) has not succeeded before.
    pub fn encode_with(
        &mut self,
        encoder: &mut CommandEncoder,
        mut own_draws: impl FnMut(&mut RenderPass<'_>, &CastTarget, &[OwnCasterId]),
    ) -> Result<(), BackendError> {
        self.encode_passes(encoder, &mut own_draws, None)
    }

    /// Records the passes like [`encode_with`](Self::encode_with), each between two timestamps.
    /// `passes` receives the timed ones.
    ///
    /// # Errors
    /// Errors if [`encode_with`](Self::encode_with) does.
    pub fn encode_timed(
        &mut self,
        encoder: &mut CommandEncoder,
        mut own_draws: impl FnMut(&mut RenderPass<'_>, &CastTarget, &[OwnCasterId]),
        stamps: &SetTimestamps<'_>,
        passes: &mut Vec<TimedPass>,
    ) -> Result<(), BackendError> {
        let timer = PassTimer::new(self.number, stamps, passes);
        self.encode_passes(encoder, &mut own_draws, Some(timer))
    }

    /// Records the hierarchy, cast and filter passes that this frame redraws.
    ///
    /// Errors if [`prepare`](Self::prepare) has not succeeded before.
    fn encode_passes(
        &mut self,
        encoder: &mut CommandEncoder,
        own_draws: OwnDraws<'_>,
        timer: Option<PassTimer<'_, '_>>,
    ) -> Result<(), BackendError> {
        if self.shader.bind_group().is_none() {
            return Err(unprepared_error());
        }
        if self.passes.count() == 0 && self.hierarchies.due_count() == 0 {
            return Ok(());
        }
        self.unsubmitted_encoders.watch(encoder);
        self.casters.instances.encode(encoder);
        let mut timer = timer;
        // Record the hierarchies.
        self.hierarchies.encode(encoder, &self.lights, |id| {
            timer.as_mut()?.compute_writes(id, SetPass::Hierarchy)
        });
        let mut clock = PassClock {
            meter: match &timer {
                Some(_) => None,
                None => self.meter.begin_frame(),
            },
            timer,
        };
        // Record the casts and filters of each light.
        let mut filtered: Option<LightKey> = None;
        let mut names = self.passes.names().enumerate().peekable();
        while let Some((pass, name)) = names.next() {
            // Skip lights that were removed since `prepare`.
            let Some(light) = self.lights.get(name.light) else {
                continue;
            };
            let filters = &light.maps.filters;
            if filtered != Some(name.light) {
                filters.clear(encoder);
                filtered = Some(name.light);
            }
            let cast = &light.maps.casts[name.cast];
            self.passes
                .encode(encoder, pass, cast, &self.casters, own_draws, &mut clock);
            // Record the filters of a light after its last cast.
            if names
                .peek()
                .is_none_or(|(_, next)| next.light != name.light)
            {
                let stamps = if filters.pass_count() > 0 {
                    clock.filters(name.light)
                } else {
                    None
                };
                filters.encode(encoder, stamps.as_ref(), 0);
            }
        }
        drop(names);
        if let Some(meter) = clock.meter {
            meter.end(encoder);
        }
        // Mark the recorded layers as up to date.
        for name in self.passes.names() {
            let Some(light) = self.lights.get_mut(name.light) else {
                continue;
            };
            let cast = &mut light.maps.casts[name.cast];
            match (name.part, &mut cast.still) {
                (PassCasters::Still, Some(still)) => still.is_stale = false,
                _ => {
                    cast.is_stale = false;
                    cast.is_drawn = true;
                }
            }
        }
        self.passes.clear();
        Ok(())
    }

    /// Records a pass for each light in [`prepare_masks`](Self::prepare_masks), after those of
    /// [`encode`](Self::encode). Returns the masks: a texture with one layer per light that
    /// contains its visibility, 1 for pixels that don't receive.
    ///
    /// # Errors
    /// Errors if [`prepare_masks`](Self::prepare_masks) has not succeeded before.
    pub fn encode_masks(&self, encoder: &mut CommandEncoder) -> Result<&TextureView, BackendError> {
        self.masks
            .encode(encoder, &self.shader, None)
            .ok_or_else(masks::unprepared_error)
    }

    /// Records the passes like [`encode_masks`](Self::encode_masks), each between two timestamps.
    /// `passes` receives the timed ones.
    ///
    /// # Errors
    /// Errors if [`encode_masks`](Self::encode_masks) does.
    pub fn encode_masks_timed(
        &self,
        encoder: &mut CommandEncoder,
        stamps: &SetTimestamps<'_>,
        passes: &mut Vec<TimedPass>,
    ) -> Result<&TextureView, BackendError> {
        let timer = PassTimer::new(self.number, stamps, passes);
        self.masks
            .encode(encoder, &self.shader, Some(timer))
            .ok_or_else(masks::unprepared_error)
    }
}
