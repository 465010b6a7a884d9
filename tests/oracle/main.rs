//! The oracle against closed forms, brute force, and frames broken on purpose.

mod analytic;
mod awkward;
mod brute_force;
mod cost;
mod frames;
mod shapes;
mod trimmed;
