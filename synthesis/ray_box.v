// One box of the ray-box unit as modules/rt_unit/intersection_unit.cpp counts it: 6 add, 6 mul, 10 compare, a register after each
// operator. A box a clock, six stages.
module ray_box(input clk, input [95:0] lower, input [95:0] upper, input [95:0] origin, input [95:0] inverse,
               input [31:0] t_min, input [31:0] t_max, output reg hit, output reg [31:0] t_entry);
  reg [95:0] lower_1, upper_1, inverse_1, lower_2, upper_2, near_3, far_3;
  reg [31:0] t_min_1, t_max_1, t_min_2, t_max_2, t_min_3, t_max_3;
  reg [31:0] near_a_4, near_b_4, far_a_4, far_b_4, near_5, far_5;
  wire [95:0] lower_0, upper_0, lower_m, upper_m, near, far;
  genvar i;
  generate
    for (i = 0; i < 96; i = i + 32) begin : axis
      fp_sub from_lower(.a(lower[i +: 32]), .b(origin[i +: 32]), .y(lower_0[i +: 32]));
      fp_sub from_upper(.a(upper[i +: 32]), .b(origin[i +: 32]), .y(upper_0[i +: 32]));
      fp_mul at_lower(.a(lower_1[i +: 32]), .b(inverse_1[i +: 32]), .y(lower_m[i +: 32]));
      fp_mul at_upper(.a(upper_1[i +: 32]), .b(inverse_1[i +: 32]), .y(upper_m[i +: 32]));
      // One comparison orders the two.
      wire less;
      fp_less order(.a(lower_2[i +: 32]), .b(upper_2[i +: 32]), .y(less));
      assign near[i +: 32] = less ? lower_2[i +: 32] : upper_2[i +: 32];
      assign far[i +: 32] = less ? upper_2[i +: 32] : lower_2[i +: 32];
    end
  endgenerate
  wire [31:0] near_a, near_b, far_a, far_b, near_c, far_c;
  fp_max max_a(.a(near_3[31:0]), .b(near_3[63:32]), .y(near_a));
  fp_max max_b(.a(near_3[95:64]), .b(t_min_3), .y(near_b));
  fp_min min_a(.a(far_3[31:0]), .b(far_3[63:32]), .y(far_a));
  fp_min min_b(.a(far_3[95:64]), .b(t_max_3), .y(far_b));
  fp_max max_c(.a(near_a_4), .b(near_b_4), .y(near_c));
  fp_min min_c(.a(far_a_4), .b(far_b_4), .y(far_c));
  wire beyond;
  fp_less last(.a(far_5), .b(near_5), .y(beyond));
  always @(posedge clk) begin
    lower_1 <= lower_0; upper_1 <= upper_0; inverse_1 <= inverse; t_min_1 <= t_min; t_max_1 <= t_max;
    lower_2 <= lower_m; upper_2 <= upper_m; t_min_2 <= t_min_1; t_max_2 <= t_max_1;
    near_3 <= near; far_3 <= far; t_min_3 <= t_min_2; t_max_3 <= t_max_2;
    near_a_4 <= near_a; near_b_4 <= near_b; far_a_4 <= far_a; far_b_4 <= far_b;
    near_5 <= near_c; far_5 <= far_c;
    hit <= !beyond; t_entry <= near_5;
  end
endmodule
