//! The one list of techniques: command line, help, tests, charts and tables all come from it.

use crate::settings;
use std::sync::Arc;
use umbrage_core::{Fit, ShadowTechnique};

/// Techniques with their settings, ready to plan.
pub type Settings = Vec<Arc<dyn ShadowTechnique>>;

/// A technique of the list.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Its name, as [`ShadowTechnique::name`] gives it.
    pub name: &'static str,
    /// What it does, in one line.
    pub summary: &'static str,
    /// The settings worth comparing, for the given map sizes and fit. Techniques without a map ignore both.
    pub settings: fn(map_sizes: &[u32], fit: Fit) -> Settings,
    /// Every setting that differs in code path: all kernels with all biases, at one small map size, for tests.
    pub exhaustive: fn(map_size: u32) -> Settings,
}

/// All built-in techniques, cheapest first.
pub fn all() -> &'static [Entry] {
    ALL
}

/// The technique with this name.
pub fn find(name: &str) -> Option<&'static Entry> {
    ALL.iter().find(|e| e.name == name)
}

const fn entry(
    name: &'static str,
    summary: &'static str,
    settings: fn(&[u32], Fit) -> Settings,
    exhaustive: fn(u32) -> Settings,
) -> Entry {
    Entry {
        name,
        summary,
        settings,
        exhaustive,
    }
}

#[rustfmt::skip]
const ALL: &[Entry] = &[
    entry("none", "no shadows: for scenes in which nothing casts onto what is seen", settings::none, settings::all_none),
    entry("hard", "one comparison with one texel (Williams 1978)", settings::hard, settings::all_hard),
    entry("second_depth", "comparisons with the far sides of closed casters, no bias (Wang, Molnar 1994)", settings::second_depth, settings::all_second_depth),
    entry("midpoint", "comparisons with the middle of the nearest two surfaces (Woo 1992)", settings::midpoint, settings::all_midpoint),
    entry("pcf_dithered", "four comparisons, placed by the pixel's parity (Bunnell, Pellacini 2004)", settings::pcf_dithered, settings::all_pcf_dithered),
    entry("pcf_hardware", "comparison samplers, each of which blends 2x2 texels", settings::pcf_hardware, settings::all_pcf_hardware),
    entry("pcf_merged", "(2r + 1)² texels in (r + 1)² weighted comparison samples (Castaño 2013)", settings::pcf_merged, settings::all_pcf_merged),
    entry("pcf", "the mean of a square of comparisons (Reeves, Salesin, Cook 1987)", settings::pcf, settings::all_pcf),
    entry("pcf_disc", "comparisons spread over a disc that each pixel turns", settings::pcf_disc, settings::all_pcf_disc),
    entry("pcss", "soft shadows: looks for blockers, then filters as widely as they ask for (Fernando 2005)", settings::pcss, settings::all_pcss),
    entry("planar", "casters flattened onto flat receivers, exact (Blinn 1988)", settings::planar, settings::all_planar),
    entry("volumes", "stencil shadow volumes, exact (Crow 1977; Everitt, Kilgard 2002)", settings::volumes, settings::all_volumes),
    entry("traced", "any-hit rays, no map (Whitted 1980; Cook, Porter, Carpenter 1984)", settings::traced, settings::all_traced),
];
