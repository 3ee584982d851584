//! The passes of a frame, recorded.

use super::{LightId, LightSet, PassCasters, unprepared};
use crate::{
    light_set::{
        cast_list::DrawnCast,
        timestamps::{PassClock, PassTimer},
    },
    targets::CastTarget,
};
use umbrage_core::BackendError;
use wgpu::{CommandEncoder, RenderPass};

impl LightSet {
    /// Records lists, casts and filters that this frame makes anew.
    ///
    /// Errors if [`prepare`](Self::prepare) has not succeeded before.
    pub(super) fn encode_passes(
        &mut self,
        encoder: &mut CommandEncoder,
        own_draws: &mut dyn FnMut(&mut RenderPass<'_>, &CastTarget),
        timer: Option<PassTimer<'_, '_>>,
    ) -> Result<(), BackendError> {
        if self.shader.bind_group().is_none() {
            return Err(unprepared());
        }
        if self.list.count() == 0 && self.lists.stale_count() == 0 {
            return Ok(());
        }
        self.dropped_encoders.watch(encoder);
        let mut timer = timer;
        self.lists.encode(encoder, |id| timer.as_mut()?.lists(id));
        let mut clock = PassClock {
            meter: match &timer {
                Some(_) => None,
                None => self.meter.begin_frame(),
            },
            timer,
        };
        let mut filtered: Option<LightId> = None;
        let mut names = self.list.names().enumerate().peekable();
        while let Some((pass, name)) = names.next() {
            let light = &self.lights[name.light];
            if filtered != Some(name.light) {
                light.filters.clear(encoder);
                filtered = Some(name.light);
            }
            let drawn = DrawnCast {
                cast: &light.casts[name.cast],
                casters: &self.casters,
                instances: &self.instances,
            };
            self.list
                .encode(encoder, pass, &drawn, own_draws, &mut clock);
            // After the light's last pass its filters follow.
            if names
                .peek()
                .is_none_or(|(_, next)| next.light != name.light)
            {
                let stamps = if light.filters.has_passes() {
                    clock.filters(name.light)
                } else {
                    None
                };
                light.filters.encode(encoder, stamps.as_ref());
            }
        }
        drop(names);
        if let Some(meter) = clock.meter {
            meter.end(encoder);
        }
        for name in self.list.names() {
            let cast = &mut self.lights[name.light].casts[name.cast];
            match (name.part, &mut cast.still) {
                (PassCasters::Still, Some(still)) => still.is_stale = false,
                _ => {
                    cast.is_stale = false;
                    cast.is_drawn = true;
                }
            }
        }
        self.list.clear();
        Ok(())
    }
}
