//! Geometry against independent methods: double-double arithmetic, another NURBS library, implicit equations.

mod accuracy;
mod bad_data;
mod charts;
mod enclosures;
mod exact_forms;
mod nurbs;
mod oracle;
mod support;
mod trimmed_area;
