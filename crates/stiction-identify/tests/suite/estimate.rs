//! Estimation on synthetic data.
