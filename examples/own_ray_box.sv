// SPDX-License-Identifier: Apache-2.0
// A ray-box unit of a user's: a pipeline that starts a node an edge and has its result LATENCY edges later.
module own_ray_box #(
    parameter LATENCY = 13,
    parameter LANE_BITS = 16
) (
    input  logic                 clk,
    input  logic                 rst,
    input  logic                 in_valid,
    output logic                 in_ready,
    input  logic [LANE_BITS-1:0] in_lane,
    output logic                 out_valid,
    output logic [LANE_BITS-1:0] out_lane,
    output logic                 idle
);
  logic [LATENCY-1:0]           valid;
  logic [LATENCY*LANE_BITS-1:0] lane;
  assign in_ready = 1'b1;
  assign out_valid = valid[LATENCY-1];
  assign out_lane = lane[LATENCY*LANE_BITS-1 -: LANE_BITS];
  assign idle = valid == '0;
  always_ff @(posedge clk) begin
    valid <= rst ? '0 : {valid[LATENCY-2:0], in_valid & in_ready};
    lane <= {lane[(LATENCY-1)*LANE_BITS-1:0], in_lane};
  end
endmodule
