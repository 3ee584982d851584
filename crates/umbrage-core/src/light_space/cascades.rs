//! Cascaded shadow maps: the split of the camera's view into slices with one layer each.
//!
//! With one map for the whole view, texels are far too large near the camera and far too small in
//! the distance. So the view is split along its depth, and each slice gets a map (Engel 2006,
//! "Cascaded shadow maps"; Zhang, Sun, Xu and Lun 2006, "Parallel-split shadow maps for large-scale
//! virtual environments"). A receiver is looked up in the finest map that contains it.

use crate::invalid::{self, Invalid};

/// Greatest number of slices.
pub const MAX_CASCADES: usize = 8;
/// A held slice shrinks once it is larger than the computed one by this factor.
const SHRINK_AT: f32 = 1.2;

/// Cascade settings, see [`Layout::Cascades`](crate::Layout::Cascades).
///
/// Slices divide the camera's view by depth, and their maps overlap. A lookup uses the first map,
/// from the camera on, that contains the receiver with the kernel's reach. If none does, it uses
/// the last map.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Cascades {
    /// Number of slices, 1 to [`MAX_CASCADES`].
    pub count: u32,
    /// Positions of the cuts between slices.
    pub split: Split,
    /// Least distance used for the split, metres along the camera's view. The split ignores a
    /// camera's near plane that is nearer, as near planes are usually much nearer than the
    /// geometry. The first slice still begins at the camera.
    pub nearest: f32,
    /// Width, in texels, of the border zone of a map in which its result is blended with that of
    /// the next map. It begins where the kernel would leave the map and extends inwards. 0 disables
    /// blending: only one map is looked up, and the change of texel size may be visible as a line.
    pub blend: f32,
}

impl Default for Cascades {
    fn default() -> Self {
        Self {
            count: 4,
            split: Split::Log,
            nearest: 4.0,
            blend: 0.0,
        }
    }
}

/// Rule for the split of a camera's view into slices.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Split {
    /// Each slice ends at the same multiple of the distance at which it begins. A texel then spans
    /// the same number of pixels in each map (Lloyd, Tuft, Yoon and Manocha 2006, "Warping and
    /// partitioning for low error shadow maps").
    #[default]
    Log,
    /// A blend of [`Split::Log`] and slices of equal length (Zhang et al. 2006).
    Practical {
        /// Share of the logarithmic split, 0..=1.
        lambda: f32,
    },
    /// Adapts to the visible receivers. Minimizes the mean size of texels in pixels over all
    /// receivers that face the light. It equals [`Split::Log`] if receivers aren't known. After
    /// Lauritzen, Salvi and Lefohn 2010, "Sample distribution shadow maps", who fit the range of
    /// visible depths; here the cuts themselves follow the receivers, too.
    ///
    /// Slices follow the camera, and texels change size with them. To keep slices stable over many
    /// frames, compute the ends of a frame with [`Fit::slice_ends`](crate::Fit::slice_ends). Pass
    /// them through [`SliceEnds::stabilized`], and use the result as [`Split::Given`].
    Receivers,
    /// Given ends.
    Given(SliceEnds),
}

/// Ends of the slices, metres along the camera's view, from the nearest on. They never decrease; a
/// slice that ends where it begins is empty.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "Vec<f32>", into = "Vec<f32>")
)]
pub struct SliceEnds {
    count: usize,
    /// Entries after the first `count` are 0.
    ends: [f32; MAX_CASCADES],
}

impl SliceEnds {
    /// Checks and returns these ends.
    ///
    /// # Errors
    /// Errors unless they are 1 to [`MAX_CASCADES`] positive numbers that never decrease.
    pub fn new(ends: &[f32]) -> Result<Self, Invalid> {
        if ends.is_empty() || ends.len() > MAX_CASCADES {
            return Err(Invalid::new(
                "slices' ends",
                format!("are {}", ends.len()),
                format!("use 1 to {MAX_CASCADES}, one for each slice"),
            ));
        }
        for &end in ends {
            invalid::positive("slice's end", end)?;
        }
        for pair in ends.windows(2) {
            if pair[1] < pair[0] {
                return Err(Invalid::new(
                    "slices' ends",
                    format!("decrease from {} to {}", pair[0], pair[1]),
                    "use them in rising order",
                ));
            }
        }
        let mut all = [0.0; MAX_CASCADES];
        all[..ends.len()].copy_from_slice(ends);
        Ok(Self {
            count: ends.len(),
            ends: all,
        })
    }

    /// Returns ends from a search's result, 1 to [`MAX_CASCADES`] numbers. They are corrected to be
    /// positive and rising.
    pub(crate) fn of_found(found: &[f64]) -> Self {
        let mut ends = [0.0; MAX_CASCADES];
        let mut last = f32::MIN_POSITIVE;
        for (end, &found) in ends.iter_mut().zip(found) {
            last = last.max((found as f32).min(f32::MAX));
            *end = last;
        }
        Self {
            count: found.len().min(MAX_CASCADES),
            ends,
        }
    }

    /// Returns the ends, metres along the camera's view.
    pub fn as_slice(&self) -> &[f32] {
        &self.ends[..self.count]
    }

    /// Returns the ends to use in a frame for which `self` was computed, if `before` was used in
    /// the frame before. An end grows at once, so that all visible geometry stays in its slice. It
    /// shrinks only once it is too large by a fifth. If the number of slices changed, returns
    /// `self`.
    ///
    /// Texels change size when an end does, and shadows shimmer in that frame.
    #[must_use]
    pub fn stabilized(&self, before: &Self) -> Self {
        if self.count != before.count {
            return *self;
        }
        let mut held = *self;
        let mut last = 0.0_f32;
        for (end, &end_before) in held.ends[..held.count].iter_mut().zip(&before.ends) {
            let stays = end_before >= *end && end_before <= *end * SHRINK_AT;
            if stays {
                *end = end_before;
            }
            // The previous end may be held while this one shrinks.
            *end = end.max(last);
            last = *end;
        }
        held
    }
}

impl TryFrom<Vec<f32>> for SliceEnds {
    type Error = Invalid;

    fn try_from(ends: Vec<f32>) -> Result<Self, Invalid> {
        Self::new(&ends)
    }
}

impl From<SliceEnds> for Vec<f32> {
    fn from(ends: SliceEnds) -> Self {
        ends.as_slice().to_vec()
    }
}

impl Cascades {
    /// Returns a short description for tables.
    pub fn label(&self) -> String {
        let slices = if self.count == 1 {
            "1 cascade".to_owned()
        } else {
            format!("{} cascades", self.count)
        };
        let split = match self.split {
            Split::Log => format!("log from {} m", self.nearest),
            Split::Practical { lambda } => format!("practical {lambda} from {} m", self.nearest),
            Split::Receivers => "by receivers".to_owned(),
            Split::Given(ends) => {
                let ends: Vec<String> = ends.as_slice().iter().map(f32::to_string).collect();
                format!("to {} m", ends.join(", "))
            }
        };
        let blend = if self.blend > 0.0 {
            format!(" blend {}", self.blend)
        } else {
            String::new()
        };
        format!("{slices} {split}{blend}")
    }

    /// Checks all parameters.
    ///
    /// # Errors
    /// Errors with the first fault found: a count or a share out of range, a negative length, or a
    /// number of ends that is not the number of slices.
    pub fn validate(&self) -> Result<(), Invalid> {
        if self.count == 0 || self.count as usize > MAX_CASCADES {
            return Err(Invalid::new(
                "cascades",
                format!("are {}", self.count),
                format!("use 1 to {MAX_CASCADES}"),
            ));
        }
        invalid::not_negative("cascades' nearest distance", self.nearest)?;
        invalid::not_negative("cascades' blend", self.blend)?;
        match self.split {
            Split::Log | Split::Receivers => Ok(()),
            Split::Practical { lambda } => {
                invalid::finite("practical split's lambda", &[lambda])?;
                if (0.0..=1.0).contains(&lambda) {
                    return Ok(());
                }
                Err(Invalid::new(
                    "practical split's lambda",
                    format!("is {lambda}"),
                    "use 0 (slices of equal length) to 1 (logarithmic)",
                ))
            }
            Split::Given(ends) if ends.count == self.count as usize => Ok(()),
            Split::Given(ends) => Err(Invalid::new(
                "cascades",
                format!("are {}, with {} given ends", self.count, ends.count),
                "use one end for each slice",
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(ends: &[f32]) -> SliceEnds {
        SliceEnds::new(ends).expect("rising")
    }

    #[test]
    fn ends_grow_at_once_and_shrink_late() {
        let before = ends(&[4.0, 20.0, 100.0]);
        assert_eq!(
            ends(&[5.0, 19.0, 70.0]).stabilized(&before),
            ends(&[5.0, 20.0, 70.0])
        );
        // Small changes are ignored.
        assert_eq!(ends(&[3.9, 18.0, 90.0]).stabilized(&before), before);
        assert_eq!(ends(&[3.9, 18.0]).stabilized(&before), ends(&[3.9, 18.0]));
    }

    #[test]
    fn held_ends_still_rise() {
        let before = ends(&[100.0, 200.0]);
        // The first end is held at 100. The second shrinks, but not below the first.
        assert_eq!(
            ends(&[90.0, 95.0]).stabilized(&before),
            ends(&[100.0, 100.0])
        );
    }

    #[test]
    fn bad_numbers_are_refused() {
        let good = Cascades::default();
        assert_eq!(good.validate(), Ok(()));
        let bad = [
            Cascades { count: 0, ..good },
            Cascades { count: 9, ..good },
            Cascades {
                nearest: -1.0,
                ..good
            },
            Cascades {
                blend: f32::NAN,
                ..good
            },
            Cascades {
                split: Split::Practical { lambda: 1.5 },
                ..good
            },
            Cascades {
                split: Split::Given(ends(&[1.0, 2.0])),
                ..good
            },
        ];
        for cascades in bad {
            let error = cascades.validate().expect_err("bad").to_string();
            assert!(error.contains("use "), "{error}");
        }
        for bad in [&[][..], &[2.0, 1.0], &[0.0], &[f32::INFINITY], &[1.0; 9]] {
            assert!(SliceEnds::new(bad).is_err(), "{bad:?}");
        }
    }
}
