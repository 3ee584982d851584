//! The nets that play recipes on both backends, and what is known of shadows from formulas.

mod agreement;
mod cascades;
mod causes;
mod closed_form;
mod closed_form_masks;
mod coarse_grids;
mod convergence;
mod culling;
mod embedding;
mod exact;
mod far_away;
mod layers;
mod maps;
mod not_finite;
mod order;
mod penumbra;
mod pictures;
mod planning;
mod plugin;
mod projections;
mod rasterisers;
mod soft;
mod stable_fit;
mod stages;
mod threads;
mod yardstick;
