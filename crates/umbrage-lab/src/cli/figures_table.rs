//! Tables of figures for a terminal.

use comfy_table::{CellAlignment, ContentArrangement, Row, Table, presets::UTF8_FULL_CONDENSED};

/// Returns a table that is no wider than the terminal. Columns from `first_figure` on are
/// right-aligned.
pub(crate) fn figures_table<R: Into<Row>>(
    header: impl Into<Row>,
    rows: impl IntoIterator<Item = R>,
    first_figure: usize,
) -> Table {
    let mut table = Table::new();
    table
        .load_style(UTF8_FULL_CONDENSED)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_header(header)
        .add_rows(rows);
    for column in table.column_iter_mut().skip(first_figure) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}
