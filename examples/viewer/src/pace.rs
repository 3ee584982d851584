//! Times of frames, and the image resolution that they allow during motion.

use web_time::{Duration, Instant};

/// Frames per second below which the image becomes coarser during motion, on software drivers and
/// on devices without timestamps, where the rate may be the display's own.
const FLUENT_WITHOUT_CLOCK: f32 = 20.0;
/// Frames per second below which the image becomes coarser on graphics cards with timestamps.
const FLUENT: f32 = 60.0;
/// Least fraction of the image's width and height.
const COARSEST: f32 = 0.25;
/// Number of steps of the scale from 0 to 1, so that images are not recreated in every frame.
const SCALE_STEPS: f32 = 16.0;
/// Time without changes before errors are measured.
pub(crate) const REST: Duration = Duration::from_millis(250);
/// Greatest such time, for slow frames.
const LONGEST_REST: Duration = Duration::from_millis(1500);

/// Times of frames.
pub(crate) struct Pace {
    /// Time between the starts of frames, smoothed, while frames follow each other.
    pub interval: Duration,
    /// CPU time of a frame.
    pub work: Duration,
    /// Fraction of the image's width and height that is drawn during motion.
    pub scale: f32,
    begun: Option<Instant>,
    changed: Instant,
    /// `true` if something moved in the last frame.
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
    /// Records a change.
    pub(crate) fn touch(&mut self) {
        self.changed = Instant::now();
    }

    /// Reports whether something has just changed.
    pub(crate) fn is_fresh(&self) -> bool {
        self.changed.elapsed() < REST
    }

    /// Reports whether nothing has changed for a while.
    pub(crate) fn rests(&self) -> bool {
        // Wait for two frames: with slow frames, the next movement may not have been processed.
        self.changed.elapsed() >= (2 * self.interval).clamp(REST, LONGEST_REST)
    }

    /// Starts a frame. Returns the time since the start of the last one.
    pub(crate) fn begin(&mut self) -> Duration {
        let now = Instant::now();
        let passed = self.begun.map_or(Duration::ZERO, |last| now - last);
        self.begun = Some(now);
        // After a rest, the time since the last frame is meaningless.
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

    /// Returns the scale of this frame's image.
    pub(crate) fn frame_scale(&self, is_moving: bool) -> f32 {
        if is_moving {
            (self.scale * SCALE_STEPS).round() / SCALE_STEPS
        } else {
            1.0
        }
    }

    /// Adapts the scale to the time between frames, for devices without usable timestamps.
    pub(crate) fn adapt_to_interval(&mut self, passed: Duration) {
        self.approach(wanted_scale(self.scale, passed, FLUENT_WITHOUT_CLOCK));
    }

    /// Adapts the scale to the device's time for an earlier frame of another scale.
    pub(crate) fn adapt_to_device(&mut self, scale: f32, took: Duration) {
        self.approach(wanted_scale(scale, took.max(self.work), FLUENT));
    }

    /// Approaches a scale: coarser at once, finer slowly.
    fn approach(&mut self, wanted: f32) {
        self.scale = if wanted < self.scale {
            wanted
        } else {
            0.8 * self.scale + 0.2 * wanted
        };
    }
}

/// Returns the scale for a frame rate, from the time of a frame at another scale. Time is
/// proportional to the number of pixels, which is the square of the scale.
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
        // Without a clock, only the frame rate is known, which may be the display's: 30, 50 or 60 a
        // second.
        for passed in [33, 20, 17].map(Duration::from_millis) {
            assert_eq!(wanted_scale(1.0, passed, FLUENT_WITHOUT_CLOCK), 1.0);
        }
    }

    #[test]
    fn slow_frames_have_as_many_pixels_as_fit_into_their_time() {
        let of_card = |scale, took| wanted_scale(scale, Duration::from_millis(took), FLUENT);
        // Twice the allowed time results in half of the pixels.
        assert!((of_card(1.0, 33) - 0.71).abs() < 0.01);
        // The result is relative to the scale of the timed frame, regardless of the current scale.
        assert!((of_card(0.5, 33) - 0.355).abs() < 0.01);
        assert!((of_card(0.5, 5) - 0.91).abs() < 0.01);
        assert_eq!((of_card(1.0, 1), of_card(1.0, 10_000)), (1.0, COARSEST));
    }
}
