//! The schema of results that are read.

use serde::Deserialize;

/// The schema alone: results of other versions have other fields.
#[derive(Deserialize)]
struct Version {
    schema: u32,
}

/// Returns the number of the schema that results say they have.
///
/// # Errors
/// Errors if the text is no JSON, or names none.
pub(crate) fn schema_of(text: &[u8]) -> serde_json::Result<u32> {
    let version: Version = serde_json::from_slice(text)?;
    Ok(version.schema)
}
