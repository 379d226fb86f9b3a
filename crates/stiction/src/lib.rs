//! Closed-chain mechanisms with friction in their joints: kinematics, driving forces, every joint
//! reaction, and friction that grows with the reactions.

pub mod dynamics;
pub mod forward;
pub mod friction;
pub mod joint;
pub mod kinematics;
pub mod linalg;
pub mod mechanism;
pub mod mobility;
pub mod parameters;
pub mod random;
pub mod scalar;
pub mod spatial;
pub mod topology;
