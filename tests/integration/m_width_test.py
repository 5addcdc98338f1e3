"""GetMWidth over the wire gives the paper's numbers, and says what is wrong with a bad parameter."""

import math
import unittest

from server_process import ServerProcess, grpc

from mwidth.v1 import stability_pb2 as stability


class MWidthTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = ServerProcess("--config", "paper")
        cls.addClassCleanup(cls.server.__exit__, None)

    def m_width(self, **overrides):
        request = stability.GetMWidthRequest(loop=stability.LoopParameters(**overrides))
        return self.server.stability.GetMWidth(request)

    def assert_ratio(self, response, lower, upper):
        nominal = response.m_width.nominal
        self.assertAlmostEqual(nominal.min / response.loop.device_mass, lower, delta=5e-8)
        self.assertAlmostEqual(nominal.max / response.loop.device_mass, upper, delta=5e-8)

    def test_paper_loop(self):
        self.assert_ratio(self.m_width(), -1.3981549, 34.2468304)

    def test_half_the_rate_and_three_times_the_cut_off(self):
        self.assert_ratio(self.m_width(period_s=0.002, cutoff_hz=30), -0.8516775, 6.7990892)

    def test_one_tick_of_delay(self):
        response = self.m_width(delay_s=0.001)
        self.assertAlmostEqual(response.m_width.nominal.max / 0.070, 14.5212851, delta=5e-8)

    def test_admitted_keeps_the_required_gain_margin(self):
        m_width = self.m_width().m_width
        self.assertEqual(m_width.required_gain_margin_db, 3)
        self.assertAlmostEqual(20 * math.log10(m_width.robust.max / m_width.admitted.max), 3, places=9)
        self.assertAlmostEqual(20 * math.log10(m_width.robust.min / m_width.admitted.min), 3, places=9)

    def test_no_damping_with_a_spring_is_empty_and_says_why(self):
        m_width = self.m_width(device_damping=0, hand_damping=0).m_width
        for interval in (m_width.nominal, m_width.robust, m_width.admitted):
            self.assertTrue(interval.empty)
            self.assertIn("damping", interval.empty_reason)
            self.assertEqual((interval.min, interval.max), (0, 0))

    def test_released_hand_has_an_m_width(self):
        m_width = self.m_width(hand_stiffness=0, hand_damping=0).m_width
        self.assertFalse(m_width.nominal.empty)
        self.assertLess(m_width.nominal.min, 0)

    def test_a_bad_parameter_is_named_with_its_range(self):
        for field, value in [("device_mass", 0), ("device_mass", -1), ("hand_stiffness", math.nan),
                             ("cutoff_hz", 501), ("delay_s", 0.0031), ("period_s", math.inf)]:
            with self.assertRaises(grpc.RpcError) as caught:
                self.m_width(**{field: value})
            self.assertEqual(caught.exception.code(), grpc.StatusCode.INVALID_ARGUMENT)
            self.assertIn(field, caught.exception.details())


if __name__ == "__main__":
    unittest.main()
