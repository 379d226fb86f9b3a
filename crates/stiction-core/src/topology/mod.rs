//! The compiled joint graph: the joints of the spanning tree, the joints that close loops (cut
//! joints), and the order of computation.
//!
//! Cut joints are chosen automatically. Bodies at which three or more chains of a loop structure
//! meet (such as a robot's platform) *float*: they have six degrees of freedom of their own and no
//! joint to a parent in the tree. Every leg is then a chain between two such bodies, or between
//! such a body and the ground, and is independent of the other legs. Each chain is cut at one
//! joint; the wrench of the cut joint is the unknown of the chain. The cost therefore grows
//! linearly with the number of legs and loops. In large mechanisms, one chain from the ground holds
//! such a body if possible.

mod graph;

use crate::joint::JointType;
use crate::mechanism::{BodyId, Gearing, Mechanism};
use core::ops::Range;
use graph::Spanning;

/// Rule for the choice of the spanning tree. Results are independent of the choice, up to
/// round-off.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TreeRule {
    /// Tree derived from the structure of the mechanism, for fast computation: bodies at which at
    /// least three chains meet float, unless the tree would have 60 or more degrees of freedom. It
    /// is then [`Self::Held`].
    Structure,
    /// Tree in which bodies do not float if one chain can hold them. The tree has fewer degrees of
    /// freedom and cut joints, and thin rods without inertia about their axis do not float.
    Held,
    /// Random tree with random floating bodies, computed from this seed. Serves to test that
    /// results do not depend on the choice of the tree.
    Random(u64),
}

/// Number of DOFs of a tree with floating hubs from which [`TreeRule::Structure`] holds the bodies.
/// Floating bodies turn about the reference point, which may be far away in a large mechanism.
const HELD: usize = 60;

/// Immutable compiled joint graph of a mechanism: spanning tree, cut joints, and order of
/// computation.
#[doc(hidden)]
#[derive(Clone, Debug)]
pub struct Topology {
    pub(crate) joint_types: Vec<JointType>,
    /// Indices of the predecessor and the successor of each joint.
    pub(crate) ends: Vec<(usize, usize)>,
    /// One node for each body except the ground, parents before children.
    pub(crate) nodes: Vec<Node>,
    /// Index of the node of each body; `None` for the ground.
    pub(crate) node_of_body: Vec<Option<usize>>,
    /// Role of each joint: part of the spanning tree, or cut joint.
    pub(crate) role: Vec<Role>,
    pub(crate) cuts: Vec<Cut>,
    /// Degrees of freedom of the spanning tree.
    pub(crate) tree_dofs: Vec<TreeDof>,
    pub(crate) coordinates: usize,
    /// Number of constraint wrenches of all cut joints. These wrenches are the unknowns of the
    /// first columns of the balance.
    pub(crate) constraints: usize,
    /// All actuated degrees of freedom in the order of [`Mechanism::actuators`].
    pub(crate) actuators: Vec<Actuator>,
    /// Actuators of cut joints, as indices into [`Self::actuators`]. Their efforts are the unknowns
    /// of the columns of the balance that follow those of the constraint wrenches.
    pub(crate) cut_actuators: Vec<usize>,
    /// Rigid gearings. Their joints are in the spanning tree, so each gearing is an equation
    /// between coordinates of the tree.
    pub(crate) gearings: Vec<GearedDofs>,
    /// True if the tree is that of the rule [`TreeRule::Held`].
    is_held: bool,
}

/// Degrees of freedom of a gearing, given by their indices in the spanning tree.
#[derive(Clone, Debug)]
pub(crate) struct GearedDofs {
    /// Index of the gearing among those of the mechanism.
    pub(crate) gearing: usize,
    /// For each coefficient of the gearing, the index of the degree of freedom among those of the
    /// spanning tree, and the index of its coordinate.
    pub(crate) dofs: Vec<(usize, usize)>,
    /// Nodes of the gearing's degrees of freedom, each listed once.
    pub(crate) nodes: Vec<usize>,
    /// True if the weighted sum is a length, false if it is an angle.
    pub(crate) is_length: bool,
}

/// Node of the spanning tree: a body and its connection to the parent body.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) body: usize,
    /// Node of the parent body; `None` if the parent is the ground or the body floats.
    pub(crate) parent: Option<usize>,
    pub(crate) link: Link,
    pub(crate) tree_dofs: Range<usize>,
    pub(crate) coordinates: Range<usize>,
}

/// Connection of a body to its parent in the spanning tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Link {
    /// Connection by a joint, given by its index; `reversed` is true if the body is the joint's
    /// predecessor.
    Joint { joint: usize, reversed: bool },
    /// Floating body, with six degrees of freedom of its own. This connection transmits no force.
    Floating,
}

/// Role of a joint in the compiled graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// Joint of the spanning tree, which connects the body of the given node with the parent body.
    Tree { node: usize },
    /// Joint that closes a loop, given by its index in [`Topology::cuts`].
    Cut { cut: usize },
}

/// Joint that closes a loop.
#[derive(Clone, Debug)]
pub(crate) struct Cut {
    pub(crate) joint: usize,
    /// Nodes between the two bodies of the joint, with the sign `+1.0` on the successor's side and
    /// `-1.0` on the predecessor's side. The nodes of each side begin at the body of that side and
    /// end below the lowest common ancestor of both bodies.
    pub(crate) path: Vec<(usize, f64)>,
    /// Indices of the joint's constraint wrenches among those of all cut joints.
    pub(crate) constraints: Range<usize>,
    /// Actuators of the joint, as indices into [`Topology::cut_actuators`].
    pub(crate) actuators: Range<usize>,
}

impl Cut {
    /// Returns the columns of the balance for the wrench of this cut joint: first those of its
    /// constraint wrenches, then those of its actuators. `constraints` is the total number of
    /// constraint columns.
    pub(crate) fn columns(
        &self,
        constraints: usize,
    ) -> impl Iterator<Item = usize> + Clone + use<> {
        let drives = self.actuators.start + constraints..self.actuators.end + constraints;
        self.constraints.clone().chain(drives)
    }
}

/// A degree of freedom of the spanning tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TreeDof {
    pub(crate) node: usize,
    /// Index of this degree of freedom among those of its joint or, for a floating body, among the
    /// six of the body.
    pub(crate) local: usize,
    /// Index of the actuator of this degree of freedom; `None` if it is not actuated.
    pub(crate) actuator: Option<usize>,
}

/// An actuated degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Actuator {
    pub(crate) joint: usize,
    pub(crate) dof: usize,
}

impl Topology {
    /// Compiles the joint graph of a mechanism.
    pub fn new(mechanism: &Mechanism) -> Self {
        Self::with_tree(mechanism, TreeRule::Structure)
    }

    /// Compiles the joint graph with a spanning tree chosen by `rule`.
    pub fn with_tree(mechanism: &Mechanism, rule: TreeRule) -> Self {
        let joints = mechanism.joints();
        let ends: Vec<_> = joints.iter().map(|j| (j.predecessor.0, j.successor.0)).collect();
        // Cutting a joint costs one unit for each resulting unknown of the balance.
        let mut cost: Vec<usize> = joints
            .iter()
            .map(|j| j.joint_type.constraints().len() + j.actuated_dofs().count())
            .collect();
        let mut keep = vec![false; joints.len()];
        for geared in mechanism.gearings().iter().flat_map(|gearing| &gearing.dofs) {
            keep[geared.joint.0] = true;
        }
        // Cost of cutting a joint with a torsion spring. This high cost keeps the joint in the
        // tree. The spring needs the number of full turns, which the angle of a cut joint does not
        // include.
        const TURNS: usize = 100;
        for spring in mechanism.joint_springs() {
            if !joints[spring.joint.0].joint_type.dofs()[spring.dof].translates() {
                cost[spring.joint.0] = TURNS;
            }
        }
        let bodies = mechanism.bodies().len();
        // A chain with more degrees of freedom than a floating body saves none, and the loops of a
        // body with many chains would all share the joints of the chain that holds the body. Two
        // held bodies may close a loop with joints of gearings, which must not be cut.
        const MANY: usize = 6;
        let dofs = |&joint: &usize| joints[joint].joint_type.dofs().len();
        let is_geared = keep.contains(&true);
        let holds = |chain: &[usize], chains: usize| {
            !is_geared && chains <= MANY && chain.iter().map(dofs).sum::<usize>() <= 6
        };
        let costs = (&cost[..], &keep[..]);
        let spanning = match rule {
            TreeRule::Structure => Spanning::by_structure(bodies, &ends, costs, |_, _| false),
            TreeRule::Held => Spanning::by_structure(bodies, &ends, costs, holds),
            TreeRule::Random(seed) => Spanning::random(bodies, &ends, &keep, seed),
        };
        let topology = Self::compile(mechanism, ends, &spanning);
        match rule {
            TreeRule::Structure if topology.dofs() >= HELD => {
                Self::with_tree(mechanism, TreeRule::Held)
            }
            _ => Self { is_held: rule == TreeRule::Held, ..topology },
        }
    }

    /// Returns true if the tree is that of the rule [`TreeRule::Held`].
    pub(crate) fn is_held(&self) -> bool {
        self.is_held
    }

    /// Compiles the joint graph with a given spanning tree: all bodies except the ground, parents
    /// before children, each with the joint to its parent; bodies without such a joint float.
    pub(crate) fn with_paths(mechanism: &Mechanism, paths: &[(usize, Option<usize>)]) -> Self {
        let ends = mechanism.joints().iter().map(|j| (j.predecessor.0, j.successor.0)).collect();
        let order = paths.iter().map(|&(body, joint)| graph::Placement { body, joint }).collect();
        Self::compile(mechanism, ends, &Spanning { order })
    }

    fn compile(mechanism: &Mechanism, ends: Vec<(usize, usize)>, spanning: &Spanning) -> Self {
        let joints = mechanism.joints();
        let mut topology = Self {
            joint_types: joints.iter().map(|j| j.joint_type).collect(),
            ends,
            nodes: Vec::new(),
            node_of_body: vec![None; mechanism.bodies().len()],
            role: vec![Role::Cut { cut: usize::MAX }; joints.len()],
            cuts: Vec::new(),
            tree_dofs: Vec::new(),
            coordinates: 0,
            constraints: 0,
            actuators: mechanism
                .actuators()
                .map(|(joint, dof)| Actuator { joint: joint.0, dof })
                .collect(),
            cut_actuators: Vec::new(),
            gearings: Vec::new(),
            is_held: false,
        };
        for placement in &spanning.order {
            topology.place(placement);
        }
        for joint in 0..joints.len() {
            if let Role::Cut { .. } = topology.role[joint] {
                topology.cut(joint);
            }
        }
        for (index, gearing) in mechanism.gearings().iter().enumerate() {
            topology.gear(index, gearing);
        }
        topology
    }

    /// Adds a gearing. Does nothing if one of its joints is not in the tree, which may happen with
    /// a tree given to [`Self::with_paths`].
    fn gear(&mut self, gearing: usize, content: &Gearing) {
        let (mut dofs, mut nodes) = (Vec::new(), Vec::new());
        for geared in &content.dofs {
            let Role::Tree { node } = self.role[geared.joint.0] else { return };
            let own = &self.nodes[node];
            dofs.push((own.tree_dofs.start + geared.dof, own.coordinates.start + geared.dof));
            if !nodes.contains(&node) {
                nodes.push(node);
            }
        }
        self.gearings.push(GearedDofs { gearing, dofs, nodes, is_length: content.is_length() });
    }

    /// Adds the node of a body; the node of its parent must exist already.
    fn place(&mut self, placement: &graph::Placement) {
        let node = self.nodes.len();
        let (link, parent_body, dofs, coordinates) = match placement.joint {
            None => (Link::Floating, 0, 6, 7),
            Some(joint) => {
                let (predecessor, successor) = self.ends[joint];
                let reversed = predecessor == placement.body;
                let parent = if reversed { successor } else { predecessor };
                self.role[joint] = Role::Tree { node };
                let joint_type = self.joint_types[joint];
                let dofs = joint_type.dofs().len();
                (Link::Joint { joint, reversed }, parent, dofs, joint_type.coordinates())
            }
        };
        let tree_dofs = self.tree_dofs.len()..self.tree_dofs.len() + dofs;
        for local in 0..dofs {
            let actuator = match link {
                Link::Joint { joint, .. } => {
                    self.actuators_of(joint).find(|&a| self.actuators[a].dof == local)
                }
                Link::Floating => None,
            };
            self.tree_dofs.push(TreeDof { node, local, actuator });
        }
        self.nodes.push(Node {
            body: placement.body,
            parent: self.node_of_body[parent_body],
            link,
            tree_dofs,
            coordinates: self.coordinates..self.coordinates + coordinates,
        });
        self.coordinates += coordinates;
        self.node_of_body[placement.body] = Some(node);
    }

    /// Adds a joint that closes a loop, as a cut joint.
    fn cut(&mut self, joint: usize) {
        self.role[joint] = Role::Cut { cut: self.cuts.len() };
        let (predecessor, successor) = self.ends[joint];
        let start = self.constraints;
        self.constraints += self.joint_types[joint].constraints().len();
        let first_actuator = self.cut_actuators.len();
        self.cut_actuators.extend(self.actuators_of(joint));
        self.cuts.push(Cut {
            joint,
            path: self.path(predecessor, successor),
            constraints: start..self.constraints,
            actuators: first_actuator..self.cut_actuators.len(),
        });
    }

    /// Returns the indices of a joint's actuators. They are consecutive, because actuators are in
    /// the order of the joints.
    fn actuators_of(&self, joint: usize) -> Range<usize> {
        let first = |joint: usize| self.actuators.partition_point(|a| a.joint < joint);
        first(joint)..first(joint + 1)
    }

    /// Lists the nodes on the path between two bodies, see [`Cut::path`].
    fn path(&self, predecessor: usize, successor: usize) -> Vec<(usize, f64)> {
        let mut of_successor = self.ancestors(successor);
        let mut of_predecessor = self.ancestors(predecessor);
        while let (Some(a), Some(b)) = (of_successor.last(), of_predecessor.last())
            && a == b
        {
            of_successor.pop();
            of_predecessor.pop();
        }
        let signed = |nodes: Vec<usize>, sign| nodes.into_iter().map(move |n| (n, sign));
        signed(of_successor, 1.0).chain(signed(of_predecessor, -1.0)).collect()
    }

    /// Returns the node of the child body of a joint in the spanning tree, or `None` for a cut
    /// joint.
    pub(crate) fn node_of(&self, joint: usize) -> Option<&Node> {
        match self.role[joint] {
            Role::Tree { node } => self.nodes.get(node),
            Role::Cut { .. } => None,
        }
    }

    /// Lists the nodes from a body up to the root of its tree.
    pub(crate) fn ancestors(&self, body: usize) -> Vec<usize> {
        let mut nodes = Vec::new();
        let mut next = self.node_of_body[body];
        while let Some(node) = next {
            nodes.push(node);
            next = self.nodes[node].parent;
        }
        nodes
    }

    /// Returns `true` if a degree of freedom of the spanning tree is a translation.
    pub(crate) fn tree_dof_translates(&self, tree_dof: &TreeDof) -> bool {
        match self.nodes[tree_dof.node].link {
            Link::Floating => tree_dof.local < 3,
            Link::Joint { joint, .. } => {
                self.joint_types[joint].dofs()[tree_dof.local].translates()
            }
        }
    }

    /// Lists the floating bodies, with the ranges of their coordinates (position relative to the
    /// reference point, unit quaternion) and of their degrees of freedom (twist about the reference
    /// point, world axes) in the spanning tree.
    pub fn floating(&self) -> impl Iterator<Item = (BodyId, Range<usize>, Range<usize>)> + '_ {
        let floating = self.nodes.iter().filter(|node| node.link == Link::Floating);
        floating.map(|node| (BodyId(node.body), node.coordinates.clone(), node.tree_dofs.clone()))
    }

    /// Number of degrees of freedom of the spanning tree.
    pub fn dofs(&self) -> usize {
        self.tree_dofs.len()
    }

    /// Number of coordinates of the spanning tree.
    pub fn coordinates(&self) -> usize {
        self.coordinates
    }

    /// Number of cut joints. Each cut joint closes one loop of the compiled graph, in which a
    /// floating body counts as connected to the ground.
    pub fn cut_joints(&self) -> usize {
        self.cuts.len()
    }

    /// Number of equations that the mechanism imposes on the coordinates of the spanning tree:
    /// constraints of cut joints, then gearings.
    pub(crate) fn closures(&self) -> usize {
        self.constraints + self.gearings.len()
    }

    /// Number of unknowns of the balance: constraint wrenches and actuator efforts of cut joints.
    pub(crate) fn columns(&self) -> usize {
        self.constraints + self.cut_actuators.len()
    }
}
