//! Tables of comma-separated values.

use crate::error::LabError;
use serde::Serialize;

/// Returns a table of records: a header with the field names, then one line per record. Errors
/// mention `file`.
///
/// # Errors
/// Errors if a record isn't flat.
pub(crate) fn of_records<T: Serialize>(
    file: &str,
    records: impl IntoIterator<Item = T>,
) -> Result<Vec<u8>, LabError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for record in records {
        writer
            .serialize(record)
            .map_err(|e| LabError::write(file, e))?;
    }
    writer
        .into_inner()
        .map_err(|e| LabError::write(file, e.into_error()))
}

/// Returns a table of texts with a header. Errors mention `file`.
///
/// # Errors
/// Errors if a line and the header have different lengths.
pub(crate) fn of_lines<L, T>(
    file: &str,
    header: &[&str],
    lines: impl IntoIterator<Item = L>,
) -> Result<Vec<u8>, LabError>
where
    L: IntoIterator<Item = T>,
    T: AsRef<[u8]>,
{
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer
        .write_record(header)
        .map_err(|e| LabError::write(file, e))?;
    for line in lines {
        writer
            .write_record(line)
            .map_err(|e| LabError::write(file, e))?;
    }
    writer
        .into_inner()
        .map_err(|e| LabError::write(file, e.into_error()))
}
