
impl State {
    /// Computes the efforts as [`State::ff`] does without a direction, and the reaction of each
    /// joint: the force of the joint's first body on its second body, N, then the moment about the
    /// joint's origin, N m, world axes. Reactions contain constraint, actuator and friction forces.
    /// They are `None` if no efforts exist. Statically indeterminate components (`stiction check`
    /// lists them) are chosen by a rule; in a real machine they may differ.
    pub fn reactions<M: Math>(
        &mut self,
        params: &Params,
        q: &[Real; COORDINATES],
        qd: &[Real; COORDINATES],
        qdd: &[Real; COORDINATES],
        tau: &mut [Real; ACTUATORS],
    ) -> (Code, Info, Option<[[Real; 6]; JOINTS]>) {
        let (code, info, found) = self.answer::<M>(params, q, (qd, qdd, None), tau);
        let mut reactions = [[0.0; 6]; JOINTS];
        for k in 0..JOINTS {
            reactions[k].copy_from_slice(&found[ACTUATORS + 6 * k..ACTUATORS + 6 * (k + 1)]);
        }
        let is_found = matches!(code, Code::Done | Code::Undetermined | Code::Frictionless);
        (code, info, if is_found { Some(reactions) } else { None })
    }
}
