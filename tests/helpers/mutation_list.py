"""Changes of the product and the tests that must fail for them.

Under the names of a test file and of a file of the product: pieces of its syntax tree as they are, and as they must not
be; see `mutated`.
"""

PIECES = {
    ("support/test_courses.py", "support/courses.py"): [
        ("np.minimum.reduceat(self.low, pairs)", "self.low[::2]"),
        ("self.rows + row", "row"),
        ("np.minimum(self.low[-1], low[0])", "low[0]"),
    ],
    ("checks/test_groups.py", "checks/groups.py"): [
        ("found[0].severity.reaches(other.severity)", "True"),
        (
            "(one.file, one.code, one.severity, one.kind, cause_of(one))",
            "(one.file, one.code, one.severity, cause_of(one))",
        ),
        ("surmised(finding.cause)", "False"),
    ],
    ("checks/importers/test_importers.py", "checks/importers.py"): [
        ("small < _LEAST_MOMENT", "small <= 0.0"),
        ("lower > upper", "lower < upper"),
        ("abs(whole) <= _LEAST_GAZEBO", "False"),
        ("small + middle < (1.0 - 2.0 * _ROUNDING) * large", "False"),
    ],
    ("checks/importers/test_importers.py", "checks/imported.py"): [
        ("os.dup2(2, 1)", "pass"),
        ("R.reshape(3, 3) * model.body_inertia[k]", "model.body_inertia[k]"),
    ],
    ("checks/importers/test_importers.py", "checks/bodies/masses.py"): [
        ("behind(relative(first, outer), inner)", "behind(outer, inner)")
    ],
    ("checks/test_config.py", "checks/catalogue.py"): [("not select or DEFAULT in select", "not select")],
    ("sizing/test_temperature.py", "loads/temperature.py"): [
        ("thermal.winding_housing * thermal.housing_capacity", "thermal.winding_housing * thermal.winding_capacity"),
        ("factor - slope * inside", "factor"),
        ("second @ first", "first @ second"),
        ("1.0 / thermal.drive_efficiency", "thermal.drive_efficiency"),
        ("_merged(np.hstack(self._kept), 2)", "np.hstack(self._kept)[:, ::2]"),
        ("np.trace(cycle) < 0.0 and np.linalg.det(cycle[:, :2]) > 0.0", "True"),
    ],
    ("sizing/test_gears_screws_and_poses.py", "loads/sizing.py"): [
        ("train.life.rated_torque / gear_mean", "gear_mean / train.life.rated_torque"),
    ],
    ("sizing/test_temperature.py", "loads/sizing.py"): [("torque * speed - tau * qd", "torque * speed")],
    ("sizing/test_gears_screws_and_poses.py", "scene/scene.py"): [
        ("(1.0 if self.gear is None else self.gear) * 2.0 * pi / self.lead", "1.0 / self.lead")
    ],
    ("dynamics/test_golden.py", "dynamics/recursions/newton_euler.py"): [
        ("joint.R.T @ wd_j + cross(w_in, joint.w) + joint.wd", "joint.R.T @ wd_j + joint.wd"),
        ("2.0", "1.0"),
        ("-gravity", "gravity"),
        ("skew(wd[-1]) + skew(w[-1]) @ skew(w[-1])", "skew(wd[-1]) - skew(w[-1]) @ skew(w[-1])"),
        ("n[j] + R @ n[i] + cross(p, f_in)", "n[j] + R @ n[i]"),
        ("cross(body.mc, a[-1])", "cross(a[-1], body.mc)"),
        ("joint.R.T @ (a_j + U_j @ joint.p)", "joint.R.T @ a_j + U_j @ joint.p"),
        ("a[-1] * body.m + U[-1] @ body.mc", "a[-1] * body.m"),
        ("x * z - dy", "x * z + dy"),
        ("y * y - z * z", "z * z - y * y"),
        ("yy - xx", "xx - yy"),
    ],
    ("dynamics/test_golden.py", "programs/vectors.py"): [("skew(axis) * sin(angle)", "-skew(axis) * sin(angle)")],
    ("dynamics/test_golden.py", "solids/inertia/laws.py"): [
        ("turned - m * product(skew(centre), skew(centre))", "turned + m * product(skew(centre), skew(centre))")
    ],
    ("dynamics/test_momentum.py", "robot/kinematics.py"): [
        ("(R @ axis) * q[0]", "axis * q[0]"),
        ("ratio * q[own]", "q[own]"),
    ],
    ("equations/test_composite.py", "equations/composite.py"): [
        ("IDENTITY * (d @ d) - np.outer(d, d)", "IDENTITY * (d @ d)"),
        ("R @ (part.I_c @ w) + cross(d, P)", "R @ (part.I_c @ w)"),
        ("(one.m * other.m)", "(one.m + other.m)"),
        ("turn @ pose.R", "pose.R"),
    ],
    ("dynamics/test_momentum.py", "dynamics/momenta.py"): [("H[j] + R @ H[i] + cross(p, P_in)", "H[j] + R @ H[i]")],
    ("dynamics/constraints/test_torque_distribution.py", "dynamics/constraints/torque_distribution.py"): [
        ("np.sqrt(weights / weights.max())", "weights / weights.max()"),
        ('wanted = forces[:, ~passive] - einsum("nij,nj->ni", drive, x)', "wanted = forces[:, ~passive]"),
    ],
    ("dynamics/constraints/test_constraint_forces.py", "dynamics/constraints/constraint_jacobian.py"): [
        ("IDENTITY[axis]", "-IDENTITY[axis]"),
    ],
    ("dynamics/contacts/test_contact_forces.py", "dynamics/contacts/dual.py"): [
        ("edge * along * sine / t", "edge * along / t"),
        ("press * sine - t * cosine", "press * cosine - t * sine"),
    ],
    ("loads/test_singular_passages.py", "dynamics/constraints/torque_distribution.py"): [
        ("1.0 / (1.0 - least[lost])", "-1.0 / least[lost]")
    ],
    ("loads/test_singular_passages.py", "loads/constraints.py"): [
        ("loads[self._lost, :n] = self._tau[self._lost]", "pass")
    ],
    ("dynamics/effects/test_external_wrench.py", "dynamics/recursions/newton_euler.py"): [
        ("n[i] - wrench.n", "n[i] + wrench.n")
    ],
    ("dynamics/effects/test_external_wrench.py", "programs/vectors.py"): [("xy - wz", "xy + wz")],
    ("dynamics/effects/test_external_wrench.py", "dynamics/effects/forces.py"): [
        ("p + R @ np.array(wrench.point)", "R @ np.array(wrench.point)"),
        ("where[body].R.T @ where[0].R", "where[body].R.T"),
    ],
    ("dynamics/effects/test_joint_effects.py", "dynamics/recursions/articulated_body.py"): [
        ("not known_zero(rotor)", "known_zero(rotor)")
    ],
    ("dynamics/effects/test_joint_effects.py", "solids/inertia/laws.py"): [("product(R, c) + p", "product(R, c) - p")],
    ("dynamics/effects/test_joint_effects.py", "dynamics/effects/rigid_bodies.py"): [
        (
            "inertia_of(load.mass, np.array(load.com), symmetric(load.inertia), R, p)",
            "inertia_of(load.mass, np.array(load.com), symmetric(load.inertia))",
        )
    ],
    ("dynamics/effects/test_joint_effects.py", "dynamics/effects/forces.py"): [
        ("sign(x) * (x * x)", "x * x"),
        ("sample.position(joint) - spring.rest", "sample.position(joint) + spring.rest"),
    ],
    ("dynamics/effects/test_joint_effects.py", "dynamics/effects/motors.py"): [
        ("gear * gear * inertia", "gear * inertia")
    ],
    ("dynamics/effects/test_joint_effects.py", "dynamics/effects/friction.py"): [
        ("friction.forward + friction.backward", "friction.forward - friction.backward"),
        ("friction.stribeck * s - coulomb", "friction.stribeck - coulomb"),
        ("friction.viscous * sample.speed(joint)", "friction.viscous * sample.qd[joint.rate]"),
    ],
    ("dynamics/test_pinocchio.py", "robot/kinematics.py"): [("turn.T @ vector(*qdd[3:])", "turn @ vector(*qdd[3:])")],
    ("dynamics/test_pinocchio.py", "dynamics/effects/rigid_bodies.py"): [("sample.qdd[:6]", "terms.qdd[:6]")],
    ("dynamics/effects/test_mimic_and_base.py", "robot/load.py"): [
        ("product(R_link, p)", "p"),
        ("product(turn, symmetric(link.inertial.inertia), turn.T)", "symmetric(link.inertial.inertia)"),
        ("multiplier * joints[i].offset", "joints[i].offset"),
    ],
    ("dynamics/effects/test_mimic_and_base.py", "dynamics/recursions/newton_euler.py"): [
        ("joint.multiplier", "1.0"),
        ("joint.R.T @ (motions[i].R @ reaction.f)", "motions[i].R @ reaction.f"),
    ],
    ("dynamics/effects/test_shares.py", "dynamics/effects/forces.py"): [
        ("sign(x) * sign(x) + sign(x)", "sign(x) * sign(x) - sign(x)")
    ],
    ("dynamics/test_function.py", "programs/run/llvm/kernel.py"): [
        ("self.homes.get(k, ())", "self.homes.get(k, ())[:1]")
    ],
    ("programs/run/test_compiled_blocks.py", "programs/run/llvm/driver.py"): [
        ("%end = add i64 %start, %filled", "%end = add i64 %start, %size"),
        ("%skip = mul i64 %start, %sample_stride", "%skip = mul i64 %start, {bytes}"),
        ("%byte = udiv i64 %start, {samples_per_byte}", "%byte = udiv i64 %start, 16"),
        ("or i64 %any, %some", "or i64 %any, 0"),
    ],
    ("programs/run/test_compiled_blocks.py", "programs/run/llvm/functions.py"): [
        (
            "_with_sign(code, code.select(odd, cosine, sine), angle.integer)",
            "_with_sign(code, code.select(odd, cosine, sine), next_quarter)",
        ),
        ('wide.whole("sub", integer, half)', "half"),
    ],
    ("programs/run/test_compiled_blocks.py", "programs/run/llvm/kernel.py"): [
        ('"ugt"', '"ogt"'),
        ("end[x] == part", "end[x] >= part"),
        ("first.get(x, x)", "x"),
        ("last[k] if k in self.products else k", "k"),
    ],
    ("programs/run/test_compiled_blocks.py", "programs/run/compiled_blocks.py"): [
        ('"little"', '"big"'),
        ("-(-samples // (pieces * block)) * block", "-(-samples // pieces)"),
        ("waiting", "[next(waiting)]"),
    ],
    ("programs/run/test_elementary_functions.py", "programs/run/llvm/functions.py"): [
        ("0x1.1701b839a2520p-88", "0x1.1701b839a2520p-89"),
        ("0x1.1a626331p-54", "0x1.1a626332p-54"),
        ("code.neg(x)", "x"),
        ("wide.fma(quarters, third, low)", "low"),
        ("wide.convert(lost, code)", "code.constant(0.0)"),
        (
            'wide.fma(wide.two("fmul", rest, rest), bend, lost)',
            'wide.fma(wide.two("fmul", rest, rest), bend, wide.constant(0.0))',
        ),
        ("710.0", "709.0"),
        ("still", "zero"),
        ("20", "24"),
    ],
    ("programs/run/test_elementary_functions.py", "programs/run/llvm/kernel.py"): [
        ("wide.fma(*square, self._total())", "self._total()")
    ],
    ("programs/run/test_fusion.py", "programs/run/llvm/kernel.py"): [
        ("x if op is ADD else code.neg(x)", "x"),
        ("z if op is ADD else code.neg(z)", "z"),
        ("op is MUL and k not in outputs", "op is MUL"),
        ("k not in taken", "True"),
        ("len(users[k])", "-len(users[k])"),
    ],
    ("programs/run/test_numpy_blocks.py", "programs/run/numpy_blocks.py"): [
        ("where[arg] >= temporary", "True"),
        ("np.sign", "lambda x, out: np.copysign(1.0, x, out)"),
    ],
    ("loads/test_blocks.py", "dynamics/arrays.py"): [("rows[:, column]", "rows[:1, column]")],
    ("loads/test_blocks.py", "loads/statistics.py"): [
        (
            "self.torque.update(time, row, size, value=tau, speed=qd)",
            "self.torque.update(time, row, tau, value=tau, speed=qd)",
        ),
        ("steady(score[columns, at]) > steady(self.score)", "steady(score[columns, at]) >= steady(self.score)"),
    ],
    ("loads/test_self_checks.py", "dynamics/momenta.py"): [
        ("s * a + y * c - z * b", "s * a + y * c + z * b"),
        ("tape.input(*each) if rate != 0.0 else x", "x"),
    ],
    ("loads/test_self_checks.py", "dynamics/effects/rigid_bodies.py"): [
        ("pose.R @ body.mc + body.m * pose.p", "-(pose.R @ body.mc + body.m * pose.p)")
    ],
    ("loads/test_self_checks.py", "loads/accumulate.py"): [
        ("execute(lost, sources, whole).values[:, 0]", "-execute(lost, sources, whole).values[:, 0]")
    ],
    ("loads/test_self_checks.py", "dynamics/effects/forces.py"): [("_positive(x)", "x")],
    ("sizing/test_catalogue.py", "sizing/catalogue.py"): [
        ("G * J * course.qdd + load / G", "load / G"),
        ("share - 1.0", "share + 1.0"),
        (
            "np.cbrt(wear / np.where(wear > 0.0, self.mean_speeds, 1.0))",
            "np.sqrt(wear / np.where(wear > 0.0, self.mean_speeds, 1.0))",
        ),
        ("G * course.mean_speeds", "course.mean_speeds"),
        ("G * course.speed", "course.speed"),
        ("tuple(masses.values())", "()"),
        ("changed = masses != before", "changed = False"),
    ],
    ("sizing/test_catalogue_tables.py", "sizing/catalogue_tables.py"): [
        ("return value * factor", "return value"),
        ("end * _ROUNDED < fast", "False"),
        ("torques > allowed * BEYOND", "torques > allowed[0]"),
        ("value > known.doubtful and not unit", "False"),
    ],
    ("loads/test_sizing_report.py", "loads/sizing.py"): [
        ("tau - (train.gear * train.gear * train.inertia) * qdd", "tau"),
        ("(train.gear * train.inertia) * qdd + load * share / train.gear", "load * share / train.gear"),
    ],
    ("loads/test_sizing_report.py", "loads/statistics.py"): [("np.abs(power)", "power")],
    ("loads/test_sizing.py", "loads/sizing.py"): [
        ("(f[:2], m)", "(f[:2], m[::-1])"),
        ("driving > 0", "driving < 0"),
        ("np.interp(speed, speeds, torques, right=0.0)", "np.interp(speed, speeds, torques)"),
        ("carried * carried * carried * np.abs(qd)", "carried * carried * carried"),
        ("size / np.maximum(peak, self.least)", "size - peak"),
        ("torque_runner(self.model, self.scene, rates)", "torque_runner(self.model, self.scene)"),
    ],
    ("loads/test_sizing.py", "loads/statistics.py"): [
        ("weights[0] += before", "weights[0] += 0.0"),
        ("1 / 3", "1 / 2"),
    ],
    ("dynamics/loops/test_closed_motion.py", "dynamics/recursions/articulated_body.py"): [
        ("turn.T if back else turn", "turn if back else turn")
    ],
    ("dynamics/loops/test_closed_chain.py", "dynamics/loops/closure.py"): [
        ("(before.R @ joint.R).T", "here.R.T"),
        ("[Twist(ZERO, axis) for axis in (before.R @ joint.R).T]", "[Twist(ZERO, axis) for axis in here.R.T]"),
        ("skew(here.bias.w) + spin @ spin", "skew(here.bias.w)"),
    ],
    ("dynamics/loops/test_closed_chain.py", "dynamics/loops/closed_chain.py"): [
        ("np.outer(product(left, one), one)", "0.0 * np.outer(product(left, one), one)"),
        ("c * lower - s * upper", "c * lower + s * upper"),
        ("c * change[i]", "change[i]"),
        ("0.0 - bias", "bias"),
    ],
    ("dynamics/loops/test_closed_chain.py", "dynamics/recursions/articulated_body.py"): [
        ("share * 2.0 if other == rate else share", "share"),
        ("own.get(k, 0.0) - row[k] * share", "own.get(k, 0.0) + row[k] * share"),
    ],
    ("measure/accuracy/test_bars_of_motions.py", "trajectory/derivatives/derive.py"): [
        ("noise[sample : sample + step] + largest", "0.2 * noise[sample : sample + step]"),
        ("times * noise + WIDER * change", "times * noise"),
    ],
    ("loads/test_largest_torque.py", "trajectory/derivatives/derive.py"): [
        ("weights[np.abs(values - surest) > bars + least] = 0.0", "weights[:] = weights")
    ],
    ("equations/test_letters.py", "equations/letters.py"): [
        ("about - (S @ S) * mass", "about + (S @ S) * mass"),
        ("return (-1.0, index)", "return (1.0, index)"),
    ],
    ("equations/test_letters.py", "equations/forms.py"): [
        ("math.copysign(2.0 * value, constant)", "math.copysign(value, constant)"),
        ("len(shorter) < len(group)", "False"),
    ],
    ("equations/dae/test_closed_dae.py", "dynamics/loops/closure.py"): [
        ("2.0 * cross(to.w, v)", "cross(to.w, v)"),
        ("-1.0", "1.0"),
        ("2.0 * cross(before.w, v)", "cross(before.w, v)"),
        ("link.wd - to.wd - cross(to.w, w)", "link.wd - to.wd"),
        ("np.outer(IDENTITY[j], R[k])", "-np.outer(IDENTITY[j], R[k])"),
    ],
    ("equations/dae/test_closed_dae.py", "equations/dae/system.py"): [
        ("total[:3] + cross(self.centres[i], f)", "total[:3]")
    ],
    ("equations/dae/test_closed_dae.py", "equations/dae/dae.py"): [
        ("independent[k] = length(stopped) > DEPENDENT", "independent[k] = True")
    ],
    ("equations/dae/test_dae.py", "equations/dae/system.py"): [
        ("2.0 * cross(w_o, u)", "1.0 * cross(w_o, u)"),
        ("2.0 * (carried @ B @ turning)", "1.0 * (carried @ B @ turning)"),
        ("B @ turning @ turning", "B @ turning"),
        ("self.constant", "0.0"),
        ("-R @ basis[i]", "R @ basis[i]"),
        ("joint.p - (centres[j] if j >= 0 else ZERO)", "joint.p - ZERO"),
        ("f - armature[i, k] * sigma[k] * S[i]", "f + armature[i, k] * sigma[k] * S[i]"),
        ("moments[i] + moment - cross(centres[i], force)", "moments[i] + moment"),
        ("weight * reaction", "reaction"),
    ],
    ("simulation/test_free_bodies_fly.py", "simulation/equations.py"): [
        ("self.equations.momentum(q, qd).m * h", "0.0 * h"),
        ("H - now.H", "now.H - H"),
    ],
    ("simulation/test_friction_and_limits.py", "dynamics/effects/forces.py"): [
        ("self.spring.damping * xd", "self.spring.damping * x")
    ],
    ("simulation/test_friction_and_limits.py", "simulation/stiff_steps.py"): [
        ("friction.dry / scene.slip_speed", "friction.dry * scene.slip_speed")
    ],
    ("simulation/test_friction_and_limits.py", "simulation/result.py"): [("(mean * lasting)[still]", "mean[still]")],
    ("simulation/test_limits_within_steps.py", "simulation/events.py"): [
        ("min(moments, default=None)", "max(moments, default=None)"),
        ("np.abs(slope) + np.abs(after)", "np.abs(slope) - np.abs(after)"),
        ("-self._gain", "self._gain"),
    ],
    ("simulation/test_limits_within_steps.py", "simulation/integrate.py"): [
        ("(touch.step + touch.at) / PARTS", "touch.at / PARTS"),
        ("kept < (len(states) if end is None else end[0])", "kept <= (len(states) if end is None else end[0])"),
    ],
    ("simulation/test_limits_within_steps.py", "measure/accuracy/simulate_within.py"): [
        ("0.5 * speed * speed / braked", "0.5 * speed / braked")
    ],
    ("simulation/test_rows_of_tables.py", "simulation/table.py"): [
        ("NEAR * rows", "0.0 * rows"),
        ("end - begin", "h + 0.0 * begin"),
        ("0.5 * length", "length"),
        (
            "changes[1:-1] |= np.diff(np.diff(columns[name]) / np.diff(rows)) != 0.0",
            "changes[2:] |= np.diff(np.diff(columns[name]) / np.diff(rows)) != 0.0",
        ),
    ],
    ("simulation/test_tables.py", "simulation/equations.py"): [
        ("speed - qd[i]", "speed + qd[i]"),
        ("[h * x for x in mean]", "[h * x for x in qd]"),
    ],
    ("simulation/test_tables.py", "simulation/table.py"): [
        ("kind == RATE", "kind != RATE"),
        ("meant * (1.0 + NEAR)", "time * (1.0 + NEAR)"),
    ],
    ("programs/test_folding.py", "programs/scalar.py"): [
        ("self - other.a", "self + other.a"),
        ("self.tape.node(SUB, self.b, self.a)", "self.tape.node(SUB, self.a, self.b)"),
        ("-self.tape.node(SIN, self.a, None)", "self.tape.node(SIN, self.a, None)"),
        ("(-self) + other", "self + other"),
        ("(op, a, b)", "(op, a)"),
        ("-(self * -other)", "self * -other"),
    ],
    ("equations/test_derive.py", "equations/derive.py"): [
        ("times(TWO, b.R.T, j.w)", "times(b.R.T, j.w)"),
        ("across(k.p - self.r, times(k.R, k.F))", "across(k.p, times(k.R, k.F))"),
        ("[times(b.I, b.wd), across(b.w, b.H)]", "[times(b.I, b.wd)]"),
        ("X[i] = X[i] - X[j] * x", "X[i] = X[i] + X[j] * x"),
        ("times(b.e.T, b.M if b.turns else b.F)", "times(b.e.T, b.M)"),
        ("b.value[i] = [*M, *F]", "b.value[i] = [*F, *M]"),
        ("-Named(AT_JOINTS[effect], part)", "Named(AT_JOINTS[effect], part)"),
    ],
    ("equations/linearized/test_linearize.py", "equations/linearized/linearize.py"): [
        ("given.dq + np.diag(robot.drives.kp)", "given.dq"),
        ("given.dqd + np.diag(robot.drives.kd)", "given.dqd"),
        ("found.B * step", "found.B"),
        ("range(1, 19)", "range(1, 9)"),
        ("2.0 * out + product(out, out)", "2.0 * out"),
    ],
    ("equations/linearized/test_linearize.py", "equations/linearized/equilibrium.py"): [
        ("rates.dq + np.diag(self.drives.kp)", "rates.dq"),
        ("self.reference - positions", "positions - self.reference"),
        ("self.speed - qd", "self.speed + qd"),
    ],
    ("equations/linearized/test_modes.py", "support/linear.py"): [
        ("left.conj() * right", "left * right"),
        ("right * scale[:, None]", "right"),
        ("left / scale[:, None]", "left"),
    ],
    ("equations/linearized/test_modes.py", "equations/linearized/modes.py"): [
        ("np.maximum(found.weight, np.abs(np.diag(found.stiffness)))", "found.weight"),
        ("k * _WRITTEN", "k * 1e-14"),
        ("a.error + b.error", "0.0"),
        ("np.minimum(errors, np.sqrt(lost * (pairs.size + lost) + soft + cuts))", "errors"),
        ("2.0 * cuts", "0.0 * cuts"),
        ("few + length((found.doubt * scales).ravel())", "few"),
        ("few + length((found.doubt * scales).ravel())", "length((found.doubt * scales).ravel())"),
        ("value * np.eye(len(own)) - own", "value.real * np.eye(len(own)) - own"),
        ("mode.real > mode.error", "mode.real > 0.0"),
        ("abs(self.real) <= self.error", "self.real == 0.0"),
    ],
    ("equations/linearized/test_modes.py", "equations/linearized/equilibrium.py"): [
        ("masses[model.parents[k]] += masses[k]", "None"),
        ("np.sqrt(stiff)[:, None]", "1.0"),
    ],
    ("equations/linearized/test_closed_chains.py", "equations/linearized/equilibrium.py"): [
        ("_beyond(model, loop.link) ^ _beyond(model, loop.to)", "range(1, model.n + 1)"),
        ('carried[rate] += entry * tape.input("multipliers", k)', "carried[rate] += entry * 0.0"),
    ],
    ("equations/linearized/test_closed_chains.py", "equations/linearized/linearize.py"): [
        ("np.hstack((-stiffness, -damping, N.T))", "np.hstack((-stiffness, -damping, np.eye(len(N))[: len(M)]))")
    ],
    ("sizing/test_retime.py", "sizing/reachability.py"): [
        ("rows.a[1] + 2.0 * steps[:, None] * rows.b[1]", "rows.a[1]"),
        ("up, level, falls = reach, after * half, half", "up, level, falls = reach, after * half, 0.5 * half"),
    ],
    ("sizing/test_retime.py", "sizing/along.py"): [
        ("(1.0 + _STEP) ** 2 - 1.0", "(1.0 + _STEP) - 1.0"),
        ("value - a * u[:, None] - b * near[..., None]", "value - a * u[:, None]"),
        ("share * (level - rises * near[..., None])", "share * level"),
    ],
    ("sizing/test_retime.py", "sizing/path.py"): [("-turn / (2.0 * (2.0 * r) ** 3)", "-turn / ((2.0 * r) ** 3)")],
    ("sizing/test_retime.py", "sizing/retime.py"): [
        ("first * u + second * sd * sd", "first * u"),
        ("np.hypot(a / j, 2.0 * np.sqrt(length / a))", "2.0 * np.sqrt(length / a)"),
        ("(now - then) / width", "now / width"),
        ("np.diff(knots) > 1e-7 * width", "np.diff(knots) > 0.0"),
    ],
    ("sizing/test_envelope.py", "sizing/directions.py"): [
        ("most + self.bulge * (np.maximum(most, 0.0) + np.maximum(back, 0.0))", "most"),
        ("moved + max(first + second - 1.0, 0.0) * back", "moved"),
        ("return most / cos(pi / len(places))", "return most"),
        ("0.5 * np.tan(aside) / tan(self.step / 2.0)", "0.4 * np.tan(aside) / tan(self.step / 2.0)"),
    ],
    ("sizing/test_envelope.py", "sizing/recursion.py"): [
        ("lattice.about(support, copysign(1.0, joint.multiplier))", "lattice.about(support)"),
        ("passed[0] += carried[i] * product(joint.p, ways[parent])", "passed[0] += 0.0"),
        ("lattice.at(found[0][key], gravity) + sprung", "lattice.at(found[0][key], gravity)"),
    ],
}
MUTATIONS: dict[str, list[tuple[str, str, str]]] = {}
"""By test file: the file of the product, the piece as it is, and as it must not be."""
for (test, file), pieces in PIECES.items():
    MUTATIONS.setdefault(test, []).extend((file, *piece) for piece in pieces)
