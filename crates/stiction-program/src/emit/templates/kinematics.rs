
/// Computes the poses of all bodies; the loops must be closed.
fn find_poses<M: Math>(w: &mut [Real; @POSE_WORK@], r: &mut [Real; 12 * BODIES + 1]) {
@POSES@}

/// Computes the twists of all bodies; the loops must be closed.
fn find_twists<M: Math>(w: &mut [Real; @TWIST_WORK@], r: &mut [Real; 6 * BODIES + 1]) {
@TWISTS@}

impl State {
    /// Forward kinematics: closes the loops at `q`, starting from the position of the last call.
    /// Returns for each body the position of its origin, m, then the rows of its rotation matrix,
    /// from body axes to world axes. The rotation of a body that can spin freely depends on the
    /// path to `q`.
    ///
    /// # Errors
    /// [`Code::BadInput`], [`Code::Open`] or [`Code::Singular`].
    pub fn poses<M: Math>(&mut self, q: &[Real; COORDINATES]) -> Result<[[Real; 12]; BODIES], Code> {
        self.close_at::<M>(q)?;
        let mut w = [0.0; @POSE_WORK@];
        let mut r = [0.0; 12 * BODIES + 1];
        w[..TREE].copy_from_slice(&self.tree);
        for k in 0..COORDINATES {
            w[TREE + 2 * k] = q[k];
        }
        find_poses::<M>(&mut w, &mut r);
        if !(r[12 * BODIES] > 0.0) || !are_finite(&r) {
            return Err(Code::Singular);
        }
        let mut poses = [[0.0; 12]; BODIES];
        for k in 0..BODIES {
            poses[k].copy_from_slice(&r[12 * k..12 * (k + 1)]);
        }
        Ok(poses)
    }

    /// Computes the twists of all bodies at positions `q` and rates `qd`: for each body the
    /// velocity of its origin, m/s, then its angular velocity, rad/s, world axes.
    ///
    /// # Errors
    /// [`Code::BadInput`], [`Code::Open`] or [`Code::Singular`].
    pub fn twists<M: Math>(
        &mut self,
        q: &[Real; COORDINATES],
        qd: &[Real; COORDINATES],
    ) -> Result<[[Real; 6]; BODIES], Code> {
        if !are_finite(qd) {
            return Err(Code::BadInput);
        }
        self.close_at::<M>(q)?;
        self.twists_at::<M>(q, qd)
    }

    /// Computes the Jacobian of the body with index `body`: the body's twist per unit rate of each
    /// coordinate. The Jacobian has six rows for the components of the twist, and a column for each
    /// coordinate.
    ///
    /// # Errors
    /// [`Code::BadInput`] (also if the body does not exist), [`Code::Open`] or [`Code::Singular`].
    pub fn jacobian<M: Math>(
        &mut self,
        q: &[Real; COORDINATES],
        body: usize,
    ) -> Result<[[Real; COORDINATES]; 6], Code> {
        if body >= BODIES {
            return Err(Code::BadInput);
        }
        self.close_at::<M>(q)?;
        let mut jacobian = [[0.0; COORDINATES]; 6];
        for column in 0..COORDINATES {
            let mut qd = [0.0; COORDINATES];
            qd[column] = 1.0;
            let twists = self.twists_at::<M>(q, &qd)?;
            for row in 0..6 {
                jacobian[row][column] = twists[body][row];
            }
        }
        Ok(jacobian)
    }

    /// Closes the loops at `q`.
    fn close_at<M: Math>(&mut self, q: &[Real; COORDINATES]) -> Result<(), Code> {
        if !are_finite(q) {
            return Err(Code::BadInput);
        }
        let mut tree = self.tree;
        if close_loops::<M>(&mut tree, q).is_none() {
            return Err(Code::Open);
        }
        self.tree = tree;
        Ok(())
    }

    /// Returns the twists of all bodies at rates `qd`; the loops must be closed at `q`.
    fn twists_at<M: Math>(
        &self,
        q: &[Real; COORDINATES],
        qd: &[Real; COORDINATES],
    ) -> Result<[[Real; 6]; BODIES], Code> {
        let mut w = [0.0; @TWIST_WORK@];
        let mut r = [0.0; 6 * BODIES + 1];
        w[..TREE].copy_from_slice(&self.tree);
        for k in 0..COORDINATES {
            w[TREE + 2 * k] = q[k];
            w[TREE + 2 * k + 1] = qd[k];
        }
        find_twists::<M>(&mut w, &mut r);
        if !(r[6 * BODIES] > 0.0) || !are_finite(&r) {
            return Err(Code::Singular);
        }
        let mut twists = [[0.0; 6]; BODIES];
        for k in 0..BODIES {
            twists[k].copy_from_slice(&r[6 * k..6 * (k + 1)]);
        }
        Ok(twists)
    }
}
