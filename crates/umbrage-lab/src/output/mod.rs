//! Output shared by all parts of the lab: folders, images, charts, pages and tables. Depends on
//! none of them.

mod checksum;
pub(crate) mod csv;
pub mod figure;
pub(crate) mod folder;
mod heat;
pub(crate) mod html;
pub mod png;
mod slug;

pub(crate) use checksum::{checksum, hash, program_hash};
pub use heat::heat_map;
pub(crate) use slug::slug;
