//! Closed-chain mechanisms with friction in their joints: kinematics, driving forces, every joint
//! reaction, and friction that grows with the reactions.

pub mod friction;
pub mod joint;
pub mod kinematics;
pub mod mechanism;
pub mod scalar;
pub mod spatial;
