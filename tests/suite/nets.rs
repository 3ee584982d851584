//! The nets that play recipes on both backends, and what is known of shadows from formulas.

mod agreement;
mod causes;
mod closed_form;
mod closed_form_masks;
mod culling;
mod embedding;
mod exact;
mod far_away;
mod maps;
mod penumbra;
mod pictures;
mod plugin;
mod rasterisers;
mod scratch;
mod stable_fit;
mod stages;
mod threads;
