//! Times of frames, and the resolution that they allow while something moves.

use web_time::{Duration, Instant};

/// Frames per second below which the picture gets coarser while something moves, on software
/// drivers, and on devices without timestamps: there the rate may be the display's own.
const FLUENT_WITHOUT_CLOCK: f32 = 20.0;
/// Frames per second below which the picture gets coarser on graphics cards with timestamps.
const FLUENT: f32 = 60.0;
/// Least share of the picture's width and height.
const COARSEST: f32 = 0.25;
/// Steps of the scale from 0 to 1, so that images are not recreated with every frame.
const SCALE_STEPS: f32 = 16.0;
/// Time without changes before errors are measured.
pub(crate) const REST: Duration = Duration::from_millis(250);
/// Greatest such time, if frames take long.
const LONGEST_REST: Duration = Duration::from_millis(1500);

/// Times of frames.
pub(crate) struct Pace {
    /// From the begin of a frame to that of the next, smoothed, while frames follow each other.
    pub interval: Duration,
    /// Work on the CPU for a frame.
    pub work: Duration,
    /// Share of the picture's width and height that is drawn while something moves.
    pub scale: f32,
    begun: Option<Instant>,
    changed: Instant,
    /// Whether something moved in the last frame.
    pub was_moving: bool,
}

impl Default for Pace {
    fn default() -> Self {
        Self {
            interval: Duration::ZERO,
            work: Duration::ZERO,
            scale: 1.0,
            begun: None,
            changed: Instant::now(),
            was_moving: false,
        }
    }
}

impl Pace {
    /// Notes a change.
    pub(crate) fn touch(&mut self) {
        self.changed = Instant::now();
    }

    /// Returns whether something changed just now.
    pub(crate) fn is_fresh(&self) -> bool {
        self.changed.elapsed() < REST
    }

    /// Returns whether nothing has changed for a while.
    pub(crate) fn rests(&self) -> bool {
        // The next movement may still be on its way if frames take longer than that.
        self.changed.elapsed() >= (2 * self.interval).clamp(REST, LONGEST_REST)
    }

    /// Begins a frame. Returns the time since the begin of the last one.
    pub(crate) fn begin(&mut self) -> Duration {
        let now = Instant::now();
        let passed = self.begun.map_or(Duration::ZERO, |last| now - last);
        self.begun = Some(now);
        // After a rest the time since the last frame has no meaning.
        if self.was_moving {
            let old = self.interval;
            self.interval = if old.is_zero() {
                passed
            } else {
                old.mul_f32(0.7) + passed.mul_f32(0.3)
            };
        }
        passed
    }

    /// Returns the scale of this frame's picture.
    pub(crate) fn frame_scale(&self, is_moving: bool) -> f32 {
        if is_moving {
            (self.scale * SCALE_STEPS).round() / SCALE_STEPS
        } else {
            1.0
        }
    }

    /// Adapts the scale to the time between frames, for devices whose own times are not used.
    pub(crate) fn adapt_to_interval(&mut self, passed: Duration) {
        self.approach(wanted_scale(self.scale, passed, FLUENT_WITHOUT_CLOCK));
    }

    /// Adapts the scale to the device's time for an earlier frame of another scale.
    pub(crate) fn adapt_to_device(&mut self, scale: f32, took: Duration) {
        self.approach(wanted_scale(scale, took.max(self.work), FLUENT));
    }

    /// Becomes coarser at once, finer slowly.
    fn approach(&mut self, wanted: f32) {
        self.scale = if wanted < self.scale {
            wanted
        } else {
            0.8 * self.scale + 0.2 * wanted
        };
    }
}

/// Returns the scale at which the frame rate is reached, from the time of a frame at another scale.
/// Time is proportional to the number of pixels: to the square of the scale.
fn wanted_scale(scale: f32, took: Duration, frames_per_second: f32) -> f32 {
    let allowed = 1.0 / frames_per_second;
    let wanted = scale * (allowed / took.as_secs_f32().max(1e-3)).sqrt();
    wanted.clamp(COARSEST, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displays_don_t_make_cards_coarser() {
        // Without a clock only the rate of frames is known, which may be the display's: 30, 50 or
        // 60 a second.
        for passed in [33, 20, 17].map(Duration::from_millis) {
            assert_eq!(wanted_scale(1.0, passed, FLUENT_WITHOUT_CLOCK), 1.0);
        }
    }

    #[test]
    fn slow_frames_have_as_many_pixels_as_fit_into_their_time() {
        let of_card = |scale, took| wanted_scale(scale, Duration::from_millis(took), FLUENT);
        // Twice as long as there is time for: half of the pixels.
        assert!((of_card(1.0, 33) - 0.71).abs() < 0.01);
        // At the scale that it was drawn at, whatever the present one is.
        assert!((of_card(0.5, 33) - 0.355).abs() < 0.01);
        assert!((of_card(0.5, 5) - 0.91).abs() < 0.01);
        assert_eq!((of_card(1.0, 1), of_card(1.0, 10_000)), (1.0, COARSEST));
    }
}
